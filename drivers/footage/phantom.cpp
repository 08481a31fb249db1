#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "drivers/errors.hpp"
#include "drivers/footage/media.hpp"
#include "drivers/quantity.hpp"

namespace shaker::footage {
namespace {

static_assert(std::endian::native == std::endian::little,
              "cine files are little endian and are read without conversion");

// Values of the compression in the bitmap header. Packed pictures are stored top row first, without padding.
constexpr std::uint32_t unpacked = 0, packed_10_bits = 256, packed_12_bits = 1024;
constexpr std::uint64_t file_header_bytes = 44;
constexpr std::uint64_t bitmap_header_bytes = 40;
constexpr std::uint64_t setup_mark_at = 140;
constexpr std::uint16_t setup_mark = 0x5453;  // "ST"
constexpr std::uint64_t setup_length_at = 142;
constexpr std::uint64_t setup_rate_at = 768;
// Tagged blocks lie between the setup and the pictures: size with this head, kind, reserved.
constexpr std::uint64_t block_head_bytes = 8;
constexpr std::uint16_t time_block = 1002;  // of each picture: fraction of a second in 2^-32 s, then seconds
constexpr double fraction_s = 1.0 / 4294967296.0;
constexpr double time_unit_s = 4 * fraction_s;  // the last two bits are flags
constexpr Range rate_allowed{1e-3, 1e8};

/// Grey pictures of a .cine file, unpacked or packed. Every value of its headers is checked against the
/// file's size before use.
class Phantom final : public Media {
public:
    explicit Phantom(const std::filesystem::path& cine) : file_{cine}, in_{cine, std::ios::binary} {
        if (!in_) throw InputError{cine.string() + ": cannot be opened: " + std::strerror(errno)};
        size_ = std::filesystem::file_size(cine);
        if (size_ < file_header_bytes || at<std::uint16_t>(0, "file header") != 0x4943)
            fail("is not a Phantom .cine file: it does not start with \"CI\"");
        if (const auto kind = at<std::uint16_t>(4, "file header"); kind != 0)
            fail("has " + std::string{kind == 2 ? "colour" : "compressed"} + " pictures (compression " +
                 std::to_string(kind) + "); only uncompressed grey pictures are supported");
        count_ = at<std::uint32_t>(20, "file header");
        read_bitmap_header(at<std::uint32_t>(24, "file header"));
        read_setup(at<std::uint32_t>(28, "file header"));
        offsets_ = at<std::uint32_t>(32, "file header");
        if (count_ == 0) fail("has no pictures");
        need(offsets_, std::uint64_t{count_} * 8, "table of " + std::to_string(count_) + " picture offsets");
        read_stamps();
    }
    [[nodiscard]] PictureFormat format() const override { return format_; }
    [[nodiscard]] std::optional<double> rate_hz() const override { return rate_hz_; }
    [[nodiscard]] std::optional<std::int64_t> count() const override { return count_; }
    [[nodiscard]] Stamps stamps() override { return {stamps_s_, time_unit_s}; }

    bool next(Picture& picture) override {
        if (next_ == count_) return false;
        const std::string what = "picture " + std::to_string(next_);
        const auto start = at<std::uint64_t>(offsets_ + std::uint64_t{next_} * 8, what);
        // Each picture is preceded by annotations. Their size includes itself and the picture's size at their
        // end.
        const auto notes = at<std::uint32_t>(start, what);
        if (notes < 8)
            fail(what + " starts with a block of " + std::to_string(notes) + " bytes; expected at least 8");
        need(start + notes, stored_.size(), what);
        read(start + notes, stored_.data(), stored_.size(), what);
        const auto row =
            static_cast<std::size_t>(format_.width) * static_cast<std::size_t>(format_.bytes_per_pixel);
        const auto height = static_cast<std::size_t>(format_.height);
        picture.number = next_;
        picture.pixels.resize(row * height);
        if (packed_bits_ > 0) {
            unpack_pixels(stored_, packed_bits_, picture.pixels);
        } else {
            for (std::size_t y = 0; y < height; ++y) {
                const std::size_t from = (bottom_up_ ? height - 1 - y : y) * (stored_.size() / height);
                std::memcpy(&picture.pixels[y * row], &stored_[from], row);
            }
        }
        ++next_;
        return true;
    }

private:
    [[noreturn]] void fail(const std::string& why) const { throw InputError{file_.string() + ": " + why}; }

    void need(std::uint64_t offset, std::uint64_t bytes, const std::string& what) const {
        if (offset > size_ || bytes > size_ - offset)
            fail("is cut short: " + what + " ends beyond its " + std::to_string(size_) + " bytes");
    }
    void read(std::uint64_t offset, std::byte* to, std::size_t bytes, const std::string& what) {
        in_.seekg(static_cast<std::streamoff>(offset));
        in_.read(reinterpret_cast<char*>(to), static_cast<std::streamsize>(bytes));
        if (!in_)
            throw DeviceError{file_.string() + ": " + what + " cannot be read: " + std::strerror(errno)};
    }
    template <class Number>
    Number at(std::uint64_t offset, const std::string& what) {
        need(offset, sizeof(Number), what);
        std::array<std::byte, sizeof(Number)> bytes;
        read(offset, bytes.data(), bytes.size(), what);
        return std::bit_cast<Number>(bytes);
    }

    void read_bitmap_header(std::uint64_t start) {
        const std::string what = "bitmap header";
        need(start, bitmap_header_bytes, what);
        const auto width = at<std::int32_t>(start + 4, what), height = at<std::int32_t>(start + 8, what);
        const auto bits = at<std::uint16_t>(start + 14, what);
        const auto compression = at<std::uint32_t>(start + 16, what);
        const std::uint64_t image_bytes = at<std::uint32_t>(start + 20, what);
        if (width < 1 || width > 65536 || height == 0 || height > 65536 || height < -65536)
            fail("pictures of " + std::to_string(width) + " x " + std::to_string(height) +
                 " pixels are not allowed");
        if (compression == unpacked && bits != 8 && bits != 16)
            fail("its pictures have " + std::to_string(bits) +
                 " bits per pixel; only grey pictures of 8 or 16 bits are supported");
        if (compression != unpacked && compression != packed_10_bits && compression != packed_12_bits)
            fail("its pictures are compressed (bitmap compression " + std::to_string(compression) +
                 "); save it with packed or unpacked grey pictures");
        // As in a DIB: with a positive height the bottom row is first, and rows are padded to 4 bytes.
        bottom_up_ = height > 0;
        packed_bits_ = compression == packed_10_bits ? 10 : compression == packed_12_bits ? 12 : 0;
        format_ = {width, std::abs(height), compression == unpacked ? bits / 8 : 2};
        const auto rows = static_cast<std::uint64_t>(format_.height),
                   row = static_cast<std::uint64_t>(width) * bits / 8;
        const std::uint64_t padded = (row + 3) / 4 * 4 * rows;
        const std::uint64_t packed = (static_cast<std::uint64_t>(width) * rows * packed_bits_ + 7) / 8;
        const std::uint64_t expected = packed_bits_ > 0            ? packed
                                       : image_bytes == row * rows ? image_bytes
                                                                   : padded;
        if (image_bytes != 0 && image_bytes != expected)
            fail("pictures of " + std::to_string(image_bytes) + " bytes do not fit " + std::to_string(width) +
                 " x " + std::to_string(format_.height) + " pixels of " +
                 std::to_string(packed_bits_ > 0 ? packed_bits_ : bits) + " bits");
        need(0, expected, "one picture");
        stored_.resize(expected);
    }

    void read_setup(std::uint64_t start) {
        const std::string what = "camera setup";
        if (at<std::uint16_t>(start + setup_mark_at, what) != setup_mark)
            fail("its camera setup does not have the mark \"ST\"");
        const double rate = at<std::uint32_t>(start + setup_rate_at, what);
        if (rate >= rate_allowed.min && rate <= rate_allowed.max) rate_hz_ = rate;
        blocks_ = start + at<std::uint16_t>(start + setup_length_at, what);
    }

    /// Times since the first picture. Blocks that are not as described are not read further.
    void read_stamps() {
        for (std::uint64_t start = blocks_; start + block_head_bytes <= offsets_;) {
            const auto bytes = at<std::uint32_t>(start, "tagged block");
            const auto kind = at<std::uint16_t>(start + 4, "tagged block");
            if (bytes < block_head_bytes || start + bytes > offsets_) return;
            if (kind == time_block && (bytes - block_head_bytes) / 8 >= count_) {
                const std::uint64_t first = start + block_head_bytes;
                const auto second = at<std::uint32_t>(first + 4, "times");
                for (std::uint64_t i = 0; i < count_; ++i) {
                    const auto fraction = at<std::uint32_t>(first + 8 * i, "times") & ~3U;
                    const auto seconds =
                        static_cast<std::int64_t>(at<std::uint32_t>(first + 8 * i + 4, "times")) - second;
                    stamps_s_.push_back(static_cast<double>(seconds) + fraction_s * fraction);
                }
                return;
            }
            start += bytes;
        }
    }

    std::filesystem::path file_;
    std::ifstream in_;
    std::uint64_t size_ = 0;
    std::uint32_t count_ = 0, next_ = 0;
    std::uint64_t offsets_ = 0;
    bool bottom_up_ = true;
    unsigned packed_bits_ = 0;       // 0: not packed
    std::vector<std::byte> stored_;  // one picture as in the file
    PictureFormat format_;
    std::optional<double> rate_hz_;
    std::uint64_t blocks_ = 0;  // where the tagged blocks begin
    std::vector<double> stamps_s_;
};

}  // namespace

std::unique_ptr<Media> open_phantom(const std::filesystem::path& cine) {
    return std::make_unique<Phantom>(cine);
}

}  // namespace shaker::footage
