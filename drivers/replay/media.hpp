#pragma once
// Recorded pictures, one at a time: movies, numbered images, and the files that makers of high-speed cameras
// write.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace shaker {

/// Grey values as they were stored: 8-bit files give 1 byte a pixel, deeper ones 2 (native endian), never
/// rescaled: a 12-bit file gives 0 to 4095, unless its maker already stored them shifted to the left.
struct Picture {
    std::vector<std::byte> pixels;  // top row first, without padding
    int missed = 0;                 // exposures that are missing in the file just before this one
};

struct PictureFormat {
    int width = 0;
    int height = 0;
    int bytes_per_pixel = 1;
    bool operator==(const PictureFormat&) const = default;
};

/// One stream of pictures of one format. One thread.
class Media {
public:
    virtual ~Media() = default;
    [[nodiscard]] virtual PictureFormat format() const = 0;
    /// Exposures a second as the file tells; none when it does not.
    [[nodiscard]] virtual std::optional<double> rate_hz() const = 0;
    /// How many pictures there are, where the file surely tells.
    [[nodiscard]] virtual std::optional<std::int64_t> count() const = 0;
    /// What the user should know about this file; empty when there is nothing.
    [[nodiscard]] virtual std::string note() const { return {}; }
    /// The next picture; false at the end. Throws InputError naming the file (and the picture) when it ends
    /// early, cannot be decoded or changes its format.
    virtual bool next(Picture& picture) = 0;
};

/// Numbers missing inside a numbered sequence of images: an error, or left out because the caller has a time
/// for each picture that is there.
enum class MissingNumbers { refused, left_out };

/// Opens by kind: a folder (all images in it, in the order of their names, where numbers count as numbers), a
/// printf pattern of images ("img_%05d.png"), .cih (Photron, beside its .mraw), .cine (Phantom), or else a
/// movie. Throws InputError naming the file when it is missing, cut short, compressed or in colour where only
/// grey is understood.
std::unique_ptr<Media> open_media(const std::filesystem::path& file, MissingNumbers missing);

/// Photron: text header (.cih) beside raw pictures (.mraw) of 8, 10, 12 or 16 bits; those of 10 and 12 are
/// packed without gaps, most significant bit first.
std::unique_ptr<Media> open_photron(const std::filesystem::path& cih);

/// Phantom: .cine with grey pictures of 8 or 16 bits, or of 10 or 12 packed like Photron's. What a 10-bit
/// camera packs is a compressed scale of greys; it is given as stored, not made linear.
std::unique_ptr<Media> open_phantom(const std::filesystem::path& cine);

/// Takes apart pixels of `bits` < 16 bits that follow each other without gaps, most significant bit first.
/// `pixels` has 2 bytes for each, already of the right size.
void unpack_pixels(const std::vector<std::byte>& packed, unsigned bits, std::vector<std::byte>& pixels);

/// Movies (OpenCV's reader gives 8 bits a pixel; colour becomes grey).
std::unique_ptr<Media> open_movie(const std::filesystem::path& file);

/// A folder or a printf pattern of 8 or 16-bit images.
std::unique_ptr<Media> open_images(const std::filesystem::path& file, MissingNumbers missing);

}  // namespace shaker
