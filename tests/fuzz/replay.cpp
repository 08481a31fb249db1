// Runs a fuzzer's function on each file of a folder, then on mutations of them, without libFuzzer. A finding
// ends the program by a signal or a sanitiser's report.
//
// A mutation is named by its file, the file that it takes pieces of, and a number; its random numbers come
// from this name alone. So the mutations are the same in each run, and a new file changes none of the others.
// With SHAKER_NIGHTLY=1 there are ten times as many, and SHAKER_SEED is part of the name.
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<char>;

struct File {
    std::string name;
    Bytes bytes;
};

std::string current;  // name of the input that is being read

// A finding is abort() or a signal; a sanitiser reports its own before.
void report(int signal) {
    static_cast<void>(::write(STDERR_FILENO, "input: ", 7));
    static_cast<void>(::write(STDERR_FILENO, current.data(), current.size()));
    static_cast<void>(::write(STDERR_FILENO, "\n", 1));
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

std::vector<File> read_all(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator{folder}) paths.push_back(entry.path());
    std::ranges::sort(paths);
    std::vector<File> all;
    for (const auto& path : paths) {
        std::ifstream in{path, std::ios::binary};
        all.push_back({path.filename().string(),
                       Bytes{std::istreambuf_iterator<char>{in}, std::istreambuf_iterator<char>{}}});
    }
    return all;
}

/// FNV-1a: equal on all machines, unlike std::hash.
std::uint64_t hash_of(std::string_view name) {
    std::uint64_t hash = 1469598103934665603ULL;
    for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
    return hash;
}

/// `of` with a piece overwritten, removed, repeated or replaced by a piece of `other`.
Bytes mutated(Bytes of, const Bytes& other, std::mt19937_64 random) {
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

void try_input(const std::string& name, const Bytes& input) {
    current = name;
    const std::vector<std::uint8_t> bytes{input.begin(), input.end()};
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
}

}  // namespace

int main(int argc, char** argv) {
    constexpr int each = 50;  // mutations of a pair of files
    if (argc != 2) return std::cerr << "usage: " << argv[0] << " FOLDER\n", 2;
    const std::vector<File> corpus = read_all(argv[1]);
    if (corpus.empty()) return std::cerr << argv[1] << " is empty\n", 1;
    const char* nightly = std::getenv("SHAKER_NIGHTLY");
    const bool all = nightly != nullptr && std::string_view{nightly} == "1";
    const char* seed = all ? std::getenv("SHAKER_SEED") : nullptr;
    const std::string campaign = seed != nullptr ? ", SHAKER_SEED=" + std::string{seed} : "";
    std::signal(SIGABRT, report);
    for (const File& file : corpus) try_input(file.name, file.bytes);
    std::cout << corpus.size() << " files read\n";
    const int count = all ? 10 * each : each;
    for (const File& file : corpus)
        for (const File& other : corpus)
            for (int i = 0; i < count; ++i) {
                const std::string name =
                    file.name + " with pieces of " + other.name + ", " + std::to_string(i) + campaign;
                try_input(name, mutated(file.bytes, other.bytes, std::mt19937_64{hash_of(name)}));
            }
    std::cout << static_cast<std::size_t>(count) * corpus.size() * corpus.size() << " mutations of them read"
              << campaign << '\n';
}
