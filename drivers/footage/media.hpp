#pragma once
// Media: recorded pictures, one at a time. Movies, numbered images, and files of high-speed cameras.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace shaker::footage {

/// Grey values as stored: 8-bit files give 1 byte per pixel, deeper ones 2 (native endian), without scaling.
/// A 12-bit file gives 0 to 4095, unless its maker stored the values shifted to the left.
struct Picture {
    std::vector<std::byte> pixels;  // top row first, without padding
    std::int64_t number = 0;        // of the file's pictures, from 0; one that cannot be decoded is left out
};

struct PictureFormat {
    int width = 0;
    int height = 0;
    int bytes_per_pixel = 1;
    bool operator==(const PictureFormat&) const = default;
};

/// Times of the pictures by a clock of the file, s, in the order of their numbers. The zero is not known.
struct Stamps {
    std::vector<double> at_s;
    double resolution_s = 0;  // unit of the stamps
};

/// One stream of pictures of one format. One thread.
class Media {
public:
    virtual ~Media() = default;
    [[nodiscard]] virtual PictureFormat format() const = 0;
    /// Exposures per second as stated in the file; empty if not stated.
    [[nodiscard]] virtual std::optional<double> rate_hz() const = 0;
    /// Times of all pictures as stated in the file; none if not stated.
    [[nodiscard]] virtual Stamps stamps() { return {}; }
    /// Number of pictures, if the file states it reliably.
    [[nodiscard]] virtual std::optional<std::int64_t> count() const = 0;
    /// Properties of this file that the user should know, one sentence each.
    [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
    /// The next picture; false at the end. Throws InputError with the file (and picture) when the file ends
    /// early, cannot be decoded or changes its format.
    virtual bool next(Picture& picture) = 0;
};

/// Numbers missing in a sequence of images: refused, or skipped because the caller has a time for each
/// existing picture.
enum class MissingNumbers { refused, left_out };

/// Opens by kind: a folder (all images in natural order of their names), a printf pattern of images
/// ("img_%05d.png"), an image (TIFF: all pages), .cih (Photron, beside its .mraw), .cine (Phantom), else a
/// movie. Throws InputError with the file when it is missing, truncated, compressed, or in colour where only
/// grey is supported.
std::unique_ptr<Media> open_media(const std::filesystem::path& file, MissingNumbers missing);

/// Files that open_media() may open for `file`: itself, its raw pictures, or the images of a folder or
/// pattern, whose folder comes first. Only names are read.
std::vector<std::filesystem::path> media_files(const std::filesystem::path& file);

/// In small letters.
std::string lower(std::string text);

/// Loads what decodes movies and images, if it is installed; otherwise the first use reports that.
void load_decoders() noexcept;

/// Endings of the raw pictures of a .cih.
inline constexpr std::array raw_extensions{".mraw", ".MRAW", ".Mraw"};

/// Photron: text header (.cih) beside raw pictures (.mraw) of 8, 10, 12 or 16 bits; 10 and 12 bits are packed
/// without gaps, most significant bit first.
std::unique_ptr<Media> open_photron(const std::filesystem::path& cih);

/// Phantom: .cine with grey pictures of 8 or 16 bits, or of 10 or 12 bits packed as in Photron's files. A
/// 10-bit camera packs a compressed scale of greys; it is returned as stored, not linearised.
std::unique_ptr<Media> open_phantom(const std::filesystem::path& cine);

/// Unpacks pixels of `bits` < 16 bits that are stored without gaps, most significant bit first. `pixels` must
/// have its final size, 2 bytes per pixel.
void unpack_pixels(const std::vector<std::byte>& packed, unsigned bits, std::vector<std::byte>& pixels);

/// Movies (8 bits per pixel through OpenCV; colour becomes grey).
std::unique_ptr<Media> open_movie(const std::filesystem::path& file);

/// True for a folder, a pattern of names, and an image.
bool are_images(const std::filesystem::path& file);

/// The images of a folder in natural order of their names, of a pattern by their numbers, or the one that is
/// named. Hidden files are left out. InputError when no image is found.
std::vector<std::filesystem::path> image_files(const std::filesystem::path& file, MissingNumbers missing);

/// 8 or 16-bit images as of image_files(); each page of an image is a picture.
std::unique_ptr<Media> open_images(const std::filesystem::path& file, MissingNumbers missing);

}  // namespace shaker::footage
