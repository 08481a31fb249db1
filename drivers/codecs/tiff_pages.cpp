// Part of the module shaker_codecs.so: the pages of a TIFF. Only its directories are read.
#include <tiffio.h>

#include <fstream>
#include <memory>

#include "drivers/codecs/codecs.hpp"
#include "drivers/errors.hpp"

namespace shaker::codecs {
namespace {

constexpr std::int64_t most_pages = 1'000'000;
constexpr std::uint64_t most_pixels = std::uint64_t{1} << 28U;  // of a page

struct CloseTiff {
    void operator()(TIFF* tiff) const noexcept { TIFFClose(tiff); }
};

bool begins_as_tiff(const std::string& file) {
    std::array<char, 4> mark{};
    std::ifstream{file, std::ios::binary}.read(mark.data(), mark.size());
    const std::string_view text{mark.data(), mark.size()};
    return text.starts_with("II*") || text.starts_with("II+") ||
           text.starts_with(std::string_view{"MM\0*", 4}) || text.starts_with(std::string_view{"MM\0+", 4});
}

}  // namespace

std::int64_t image_pages(const std::string& file) {
    if (!begins_as_tiff(file)) return 1;
    TIFFSetErrorHandler(nullptr);
    TIFFSetWarningHandler(nullptr);
    const std::unique_ptr<TIFF, CloseTiff> tiff{TIFFOpen(file.c_str(), "rm")};  // m: not mapped
    if (!tiff) return 1;  // the decoder reports what is wrong
    std::int64_t pages = 0;
    do {
        std::uint32_t width = 0, height = 0;
        TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width);
        TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height);
        if (std::uint64_t{width} * height > most_pixels)
            throw InputError{file + ": page " + std::to_string(pages) + " has " + std::to_string(width) +
                             " x " + std::to_string(height) + " pixels; at most " +
                             std::to_string(most_pixels) + " are allowed"};
        if (++pages > most_pages)
            throw InputError{file + ": has more than " + std::to_string(most_pages) + " pages"};
    } while (TIFFReadDirectory(tiff.get()) == 1);
    return pages;
}

}  // namespace shaker::codecs
