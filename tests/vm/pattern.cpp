#include "tests/vm/pattern.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <iterator>
#include <unordered_map>
#include <vector>

#include "drivers/errors.hpp"

namespace shaker {

namespace {

constexpr int size_of(int bits) noexcept { return bits > 16 ? 4 : 2; }  // bytes of a sample

// A window of samples: one code of 16 bits comes again, four in a row do not.
using Window = std::array<std::int32_t, 4>;

struct WindowHash {
    std::size_t operator()(const Window& w) const noexcept {
        std::uint64_t h = 0;
        for (const std::int32_t code : w) h = (h ^ static_cast<std::uint32_t>(code)) * 0x9E3779B97F4A7C15U;
        return h;
    }
};

Window window_at(const std::int32_t* codes) noexcept { return {codes[0], codes[1], codes[2], codes[3]}; }

}  // namespace

std::vector<std::int32_t> read_first_channel(const std::string& path, int bits) {
    std::ifstream file{path, std::ios::binary};
    if (!file) throw InputError{path + ": cannot be read"};
    const std::vector<char> bytes{std::istreambuf_iterator<char>{file}, {}};
    constexpr std::size_t wav_header = 44;
    const bool wav = bytes.size() >= wav_header && std::memcmp(bytes.data(), "RIFF", 4) == 0;
    const auto size = static_cast<std::size_t>(size_of(bits));
    std::vector<std::int32_t> samples;
    for (std::size_t at = wav ? wav_header : 0; at + 2 * size <= bytes.size(); at += 2 * size) {
        std::uint32_t word = 0;
        std::memcpy(&word, bytes.data() + at, size);
        const auto unused = static_cast<unsigned>(32 - 8 * size_of(bits));
        samples.push_back(static_cast<std::int32_t>(word << unused) >> unused);
    }
    return samples;
}

PatternFound find_pattern(const std::string& path, int bits, std::int64_t frames) {
    const std::vector<std::int32_t> heard = read_first_channel(path, bits);
    std::vector<std::int32_t> played(static_cast<std::size_t>(frames));
    for (std::size_t n = 0; n < played.size(); ++n)
        played[n] = pattern_code(static_cast<std::int64_t>(n), bits) * (1 << (8 * size_of(bits) - bits));
    constexpr std::size_t width = Window{}.size();
    std::unordered_map<Window, std::size_t, WindowHash> place;
    for (std::size_t n = 0; n + width <= played.size(); ++n) place.emplace(window_at(&played[n]), n);

    PatternFound found;
    std::size_t next = 0;  // sample of the pattern after the last piece
    for (std::size_t i = 0; i < heard.size();) {
        const auto hit = i + width <= heard.size() ? place.find(window_at(&heard[i])) : place.end();
        if (hit == place.end()) {
            if (heard[i++] != 0) ++found.foreign;
            continue;
        }
        const std::size_t from = hit->second;
        std::size_t length = 0;
        while (i + length < heard.size() && from + length < played.size() &&
               heard[i + length] == played[from + length])
            ++length;
        if (from < next) {
            found.repeated += static_cast<std::int64_t>(length);
        } else {
            if (found.pieces++ > 0) found.skipped += static_cast<std::int64_t>(from - next);
            found.exact += static_cast<std::int64_t>(length);
            next = from + length;
        }
        found.longest = std::max(found.longest, static_cast<std::int64_t>(length));
        i += length;
    }
    return found;
}

}  // namespace shaker
