// Runs a fuzzer's function on each file of a folder, then on mutations chosen by SHAKER_SEED, without
// libFuzzer. A finding ends the program by a signal or a sanitiser's report.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<char>;

std::vector<Bytes> read_all(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator{folder}) paths.push_back(entry.path());
    std::ranges::sort(paths);
    std::vector<Bytes> all;
    for (const auto& path : paths) {
        std::ifstream file{path, std::ios::binary};
        all.emplace_back(std::istreambuf_iterator<char>{file}, std::istreambuf_iterator<char>{});
    }
    return all;
}

/// `of` with a piece overwritten, removed, repeated or replaced by a piece of `other`.
Bytes mutated(Bytes of, const Bytes& other, std::mt19937_64& random) {
    const auto below = [&](std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random() % n); };
    for (std::size_t changes = 1 + below(4); changes > 0 && !of.empty(); --changes) {
        const std::size_t at = below(of.size()), length = std::min(1 + below(16), of.size() - at);
        const auto begin = of.begin() + static_cast<std::ptrdiff_t>(at);
        const auto end = begin + static_cast<std::ptrdiff_t>(length);
        const std::size_t from = below(other.size()), taken = std::min(length, other.size() - from);
        const Bytes piece{begin, end};
        switch (below(4)) {
            case 0:
                std::generate(begin, end, [&] { return static_cast<char>(random()); });
                break;
            case 1:
                of.erase(begin, end);
                break;
            case 2:
                of.insert(end, piece.begin(), piece.end());
                break;
            default:
                std::copy_n(other.begin() + static_cast<std::ptrdiff_t>(from), taken, begin);
        }
    }
    return of;
}

void try_input(const Bytes& input) {
    const std::vector<std::uint8_t> bytes{input.begin(), input.end()};
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
}

}  // namespace

int main(int argc, char** argv) {
    constexpr int mutants_each = 100;
    if (argc != 2) return std::cerr << "usage: " << argv[0] << " FOLDER\n", 2;
    const std::vector<Bytes> corpus = read_all(argv[1]);
    if (corpus.empty()) return std::cerr << argv[1] << " is empty\n", 1;
    const char* text = std::getenv("SHAKER_SEED");
    const unsigned long seed = text != nullptr ? std::strtoul(text, nullptr, 10) : 1;
    std::mt19937_64 random{seed};
    for (const Bytes& input : corpus) try_input(input);
    std::cout << corpus.size() << " files read\n";
    for (const Bytes& input : corpus)
        for (int i = 0; i < mutants_each; ++i)
            try_input(mutated(input, corpus[random() % corpus.size()], random));
    std::cout << mutants_each * corpus.size() << " mutations of them read (SHAKER_SEED=" << seed << ")\n";
}
