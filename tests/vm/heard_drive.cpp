#include "tests/vm/heard_drive.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>

#include "drivers/errors.hpp"
#include "tests/vm/pattern.hpp"

namespace shaker {

namespace {

constexpr std::size_t width = 16;     // samples that locate a place in the drive
constexpr std::size_t reach = 96000;  // samples that a card may skip

using Codes = std::span<const std::int32_t>;

// The place of the window at `i` in the drive from `next` on; none for a quiet window, which may be in many
// places.
std::optional<std::size_t> place_of(Codes heard, std::size_t i, Codes drive, std::size_t next, int loud) {
    const Codes window = heard.subspan(i, std::min(width, heard.size() - i));
    const auto quiet = [&](std::int32_t code) { return std::abs(code) < loud; };
    if (window.size() < width || std::ranges::all_of(window, quiet)) return std::nullopt;
    const Codes within = drive.subspan(next, std::min(reach, drive.size() - next));
    const auto found = std::ranges::search(within, window);
    if (found.empty()) return std::nullopt;
    return next + static_cast<std::size_t>(found.begin() - within.begin());
}

}  // namespace

DriveFound find_drive(const std::string& path, int bits, const std::vector<std::int32_t>& drive) {
    const std::vector<std::int32_t> heard = read_first_channel(path, bits);
    const int loud = 1 << ((bits > 16 ? 32 : 16) - 6);
    DriveFound found;
    std::size_t next = 0, from = 0;  // samples of drive and recording after the last piece
    for (std::size_t i = 0; i < heard.size();) {
        const auto place = place_of(heard, i, drive, next, loud);
        if (!place) {
            found.foreign += heard[i++] != 0 ? 1 : 0;
            continue;
        }
        ++found.pieces;
        std::size_t k = *place;
        for (; i > from && k > next && heard[i - 1] == drive[k - 1];
             --i, --k)  // the quiet start of the piece
            found.foreign -= heard[i - 1] != 0 ? 1 : 0;
        for (; next < k; ++next) found.skipped += drive[next] != 0 ? 1 : 0;
        for (; i < heard.size() && next < drive.size() && heard[i] == drive[next]; ++i, ++next)
            found.exact += heard[i] != 0 ? 1 : 0;
        from = i;
    }
    return found;
}

void write_codes(const std::string& path, const std::vector<std::int32_t>& codes) {
    std::ofstream file{path, std::ios::binary};
    file.write(reinterpret_cast<const char*>(codes.data()),
               static_cast<std::streamsize>(codes.size() * sizeof(std::int32_t)));
    if (!file) throw InputError{path + ": cannot be written"};
}

std::vector<std::int32_t> read_codes(const std::string& path) {
    std::ifstream file{path, std::ios::binary};
    if (!file) throw InputError{path + ": cannot be read"};
    std::vector<std::int32_t> codes(std::filesystem::file_size(path) / sizeof(std::int32_t));
    file.read(reinterpret_cast<char*>(codes.data()),
              static_cast<std::streamsize>(codes.size() * sizeof(std::int32_t)));
    return codes;
}

}  // namespace shaker
