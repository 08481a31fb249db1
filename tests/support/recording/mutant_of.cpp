#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <random>

#include "tests/support/recording/mutants.hpp"

namespace shaker::test {

namespace {

class Surgeon {
public:
    Surgeon(const std::string& bytes, const Structure& structure, std::uint64_t seed)
        : random_{seed}, structure_{structure}, mutant_{.bytes = bytes, .what = {}} {}

    Mutant operate() {
        mutant_.sealed = below(2) == 0;
        for (std::uint64_t wounds = 1 + below(3); wounds > 0 && mutant_.bytes.size() > 64; --wounds) {
            const std::uint64_t kind = below(20);
            if (kind < 8) {
                flip();
            } else if (kind < 14) {
                overwrite();
            } else if (kind < 17) {
                splice();
            } else if (kind < 19) {
                swap();
            } else {
                truncate();
            }
        }
        if (mutant_.sealed) seal(mutant_.bytes, structure_);
        return std::move(mutant_);
    }

private:
    std::uint64_t below(std::uint64_t n) { return random_() % n; }

    /// A position with at least `length` bytes after it; mostly one that is not zero.
    std::size_t place(std::size_t length) {
        const std::size_t last = mutant_.bytes.size() - length;
        if (below(10) < 2) return below(last + 1);
        std::size_t at = 0;
        for (int tries = 0; tries < 8; ++tries) {
            // A block that is sealed is one of the library's own; all others are reached as often together.
            const auto& from =
                !structure_.sealed.empty() && below(2) == 0 ? structure_.sealed : structure_.described;
            const Stretch s = from[below(from.size())];
            at = std::min(s.begin + below(s.end - s.begin), last);
            if (mutant_.bytes[at] != 0) break;
        }
        return at;
    }
    void note(const char* what, std::size_t at) { mutant_.what += fmt::format("{} {}; ", what, at); }

    void flip() {
        const std::size_t at = place(1);
        mutant_.bytes[at] = static_cast<char>(mutant_.bytes[at] ^ static_cast<char>(1U << below(8)));
        note("bit flipped at", at);
    }
    void overwrite() {
        const std::size_t width = std::size_t{1} << below(4), at = place(width);
        const std::uint64_t size = mutant_.bytes.size();
        const std::array<std::uint64_t, 12> values{0,
                                                   1,
                                                   ~std::uint64_t{0},
                                                   ~std::uint64_t{0} - 1,
                                                   INT64_MAX,
                                                   std::uint64_t{1} << 63U,
                                                   0x7fffffffU,
                                                   0x80000000U,
                                                   std::uint64_t{1} << 32U,
                                                   size,
                                                   size - 1,
                                                   random_()};
        const std::uint64_t value = values[below(values.size())];
        for (std::size_t i = 0; i < width; ++i)
            mutant_.bytes[at + i] = static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
        note("word overwritten at", at);
    }
    void splice() {
        const std::size_t length = std::min<std::size_t>(1 + below(64), mutant_.bytes.size());
        const std::size_t from = place(length), to = place(length);
        const std::string block = mutant_.bytes.substr(from, length);
        mutant_.bytes.replace(to, length, block);
        note("block spliced at", to);
    }
    void swap() {
        const std::size_t length = std::min<std::size_t>(8 + below(512), mutant_.bytes.size());
        const std::size_t a = place(length), b = place(length);
        const std::string first = mutant_.bytes.substr(a, length), second = mutant_.bytes.substr(b, length);
        mutant_.bytes.replace(a, length, second);
        mutant_.bytes.replace(b, length, first);
        note("block swapped at", a);
    }
    void truncate() {
        const std::size_t to = below(mutant_.bytes.size());
        mutant_.bytes.resize(to);
        note("truncated to", to);
    }

    std::mt19937_64 random_;
    const Structure& structure_;
    Mutant mutant_;
};

}  // namespace

Mutant mutant_of(const std::string& bytes, const Structure& structure, std::uint64_t seed) {
    return Surgeon{bytes, structure, seed}.operate();
}

}  // namespace shaker::test
