#include "drivers/footage/media.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/imgproc.hpp>

#include "drivers/codecs/codecs.hpp"
#include "drivers/errors.hpp"

namespace shaker::footage {
namespace {

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

bool same_channels(const cv::Mat& image) {
    const auto channels = static_cast<std::size_t>(image.channels());
    const std::size_t bytes = image.elemSize1();
    for (int y = 0; y < image.rows; ++y) {
        const auto* pixel = image.ptr<std::byte>(y);
        for (int x = 0; x < image.cols; ++x, pixel += channels * bytes)
            if (std::memcmp(pixel, pixel + bytes, bytes) != 0 ||
                std::memcmp(pixel, pixel + 2 * bytes, bytes) != 0)
                return false;
    }
    return true;
}

/// Grey that was stored as colour is recovered exactly; real colour is weighted, which rounds.
cv::Mat grey_of(const cv::Mat& image) {
    cv::Mat grey;
    if (image.channels() == 1) return image;
    if (image.channels() == 2 || same_channels(image))
        cv::extractChannel(image, grey, 0);
    else
        cv::cvtColor(image, grey, image.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
    return grey;
}

PictureFormat format_of(const cv::Mat& image) {
    return {image.cols, image.rows, static_cast<int>(image.elemSize1())};
}

void copy_pixels(const cv::Mat& grey, std::vector<std::byte>& pixels) {
    const std::size_t row = static_cast<std::size_t>(grey.cols) * grey.elemSize();
    pixels.resize(row * static_cast<std::size_t>(grey.rows));
    for (int y = 0; y < grey.rows; ++y)
        std::memcpy(&pixels[static_cast<std::size_t>(y) * row], grey.ptr<std::byte>(y), row);
}

std::string described(const PictureFormat& f) {
    return std::to_string(f.width) + " x " + std::to_string(f.height) + " pixels of " +
           std::to_string(8 * f.bytes_per_pixel) + " bits";
}

void require_format(const std::string& what, const PictureFormat& here, const PictureFormat& first) {
    if (here != first)
        throw InputError{what + " has " + described(here) + ", the first one has " + described(first)};
}

/// FFmpeg's names of raw formats have the bits per channel as their last byte, or as the first if big endian.
bool deeper_than_8_bits(const cv::VideoCapture& capture) {
    const auto name =
        static_cast<std::uint32_t>(static_cast<int>(capture.get(cv::CAP_PROP_CODEC_PIXEL_FORMAT)));
    const auto bits = [](std::uint32_t byte) { return byte > 8 && byte <= 16; };
    return bits(name >> 24U) || bits(name & 0xFFU);
}

class Movie final : public Media {
public:
    explicit Movie(const std::filesystem::path& file) : file_{file.string()} {
        if (!std::filesystem::exists(file)) throw InputError{file_ + ": No such file or directory"};
        if (!capture_->open(file_, codecs::has_ffmpeg() ? cv::CAP_FFMPEG : cv::CAP_ANY))
            throw InputError{file_ + ": is not a movie that can be opened"};
        if (!capture_->read(ahead_) || ahead_.empty())
            throw InputError{file_ + ": no picture of this movie can be decoded"};
        ahead_ = grey_of(ahead_).clone();
        format_ = format_of(ahead_);
        at_ms_ = capture_->get(cv::CAP_PROP_POS_MSEC);
    }
    [[nodiscard]] PictureFormat format() const override { return format_; }
    [[nodiscard]] std::optional<double> rate_hz() const override {
        const double rate = capture_->get(cv::CAP_PROP_FPS);
        if (rate > 0.01 && rate < 1e7) return rate;
        return {};
    }
    [[nodiscard]] std::optional<std::int64_t> count() const override { return {}; }
    [[nodiscard]] std::string note() const override {
        if (!deeper_than_8_bits(*capture_)) return {};
        return file_ +
               " has more than 8 bits per pixel, but only 8 can be read from a movie; numbered 16-bit "
               "images keep all";
    }

    bool next(Picture& picture) override {
        if (ahead_.empty()) return false;
        copy_pixels(ahead_, picture.pixels);
        picture.missed = missed_;
        ++given_;
        // A picture that cannot be decoded fails once; the end of the movie fails repeatedly.
        if (!capture_->read(ahead_) && !capture_->read(ahead_)) ahead_.release();
        if (ahead_.empty()) {
            require_end();
            return true;
        }
        ahead_ = grey_of(ahead_);
        require_format(file_ + ": picture " + std::to_string(given_), format_of(ahead_), format_);
        advance_clock();
        return true;
    }

private:
    /// OpenCV silently skips pictures that it cannot decode. They are detected by the movie's time stamps if
    /// these are fine enough: containers count milliseconds, so steps below 5 ms prove nothing.
    void advance_clock() {
        const double now = capture_->get(cv::CAP_PROP_POS_MSEC);
        const double step = now - at_ms_;
        missed_ = 0;
        if (!(step > 0)) return;
        at_ms_ = now;
        shortest_ms_ = shortest_ms_ > 0 ? std::min(shortest_ms_, step) : step;
        const double steps = step / shortest_ms_;
        const double whole = std::round(steps);
        if (shortest_ms_ >= 5 && whole >= 2 && whole < 1e6 && std::abs(steps - whole) < 0.2)
            missed_ = static_cast<int>(whole) - 1;
    }

    void require_end() const {
        const double rate = capture_->get(cv::CAP_PROP_FPS),
                     promised = capture_->get(cv::CAP_PROP_FRAME_COUNT);
        if (!(rate > 0 && promised > 0 && at_ms_ > 0 && given_ > 1)) return;
        const double step_ms = at_ms_ / static_cast<double>(given_ - 1), end_ms = 1e3 * promised / rate;
        if (end_ms - at_ms_ > 3.5 * std::max(step_ms, 1e3 / rate))
            throw InputError{file_ + ": is cut short: picture " + std::to_string(given_ - 1) + " at " +
                             std::to_string(at_ms_ / 1e3) +
                             " s is the last that can be decoded, the movie's header "
                             "promises " +
                             std::to_string(end_ms / 1e3) + " s"};
    }

    std::string file_;
    std::unique_ptr<cv::VideoCapture> capture_ = codecs::new_capture();
    cv::Mat ahead_;
    PictureFormat format_;
    std::int64_t given_ = 0;
    int missed_ = 0;
    double at_ms_ = 0;
    double shortest_ms_ = 0;
};

class Images final : public Media {
public:
    explicit Images(std::vector<std::filesystem::path> files) : files_{std::move(files)} {
        format_ = format_of(load(files_.front()));
    }
    [[nodiscard]] PictureFormat format() const override { return format_; }
    [[nodiscard]] std::optional<double> rate_hz() const override { return {}; }
    [[nodiscard]] std::optional<std::int64_t> count() const override {
        return static_cast<std::int64_t>(files_.size());
    }
    bool next(Picture& picture) override {
        if (next_ == files_.size()) return false;
        const auto& file = files_[next_++];
        const cv::Mat grey = load(file);
        require_format(file.string() + ": this image", format_of(grey), format_);
        copy_pixels(grey, picture.pixels);
        picture.missed = 0;
        return true;
    }

private:
    static cv::Mat load(const std::filesystem::path& file) {
        return grey_of(codecs::read_image(file.string()));
    }

    std::vector<std::filesystem::path> files_;
    PictureFormat format_;
    std::size_t next_ = 0;
};

bool is_image(const std::filesystem::path& file) {
    constexpr std::array extensions{".png", ".tif", ".tiff", ".pgm", ".pnm", ".bmp", ".jpg", ".jpeg"};
    const std::string extension = lower(file.extension().string());
    return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

/// Natural order, "img_2" before "img_10": runs of digits are compared as numbers.
bool natural_less(const std::string& a, const std::string& b) {
    const auto digit = [](char c) { return c >= '0' && c <= '9'; };
    const auto run = [&](const std::string& s, std::size_t& i) {
        while (i < s.size() && s[i] == '0') ++i;
        const std::size_t from = i;
        while (i < s.size() && digit(s[i])) ++i;
        return std::string_view{s}.substr(from, i - from);
    };
    std::size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (digit(a[i]) && digit(b[j])) {
            const auto m = run(a, i), n = run(b, j);
            if (m != n) return m.size() != n.size() ? m.size() < n.size() : m < n;
        } else if (a[i] != b[j]) {
            return a[i] < b[j];
        } else {
            ++i, ++j;
        }
    }
    const bool a_ended = i == a.size(), b_ended = j == b.size();
    return a_ended && b_ended ? a < b : a_ended;
}

std::vector<std::filesystem::path> images_in(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        if (entry.is_regular_file() && is_image(entry.path())) files.push_back(entry.path());
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
        return natural_less(a.filename().string(), b.filename().string());
    });
    if (files.empty()) throw InputError{folder.string() + ": no images in this folder"};
    return files;
}

/// The parts of "img_%05d.png".
struct Pattern {
    std::string before, after;
    std::size_t width = 0;

    [[nodiscard]] std::string name(std::int64_t number) const {
        std::string digits = std::to_string(number);
        if (digits.size() < width) digits.insert(0, width - digits.size(), '0');
        return before + digits + after;
    }
    [[nodiscard]] std::optional<std::int64_t> number(std::string_view text) const {
        if (!text.starts_with(before)) return {};
        text.remove_prefix(before.size());
        std::int64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc{} || value < 0 || name(value) != before + std::string{text}) return {};
        return value;
    }
};

Pattern parsed_pattern(const std::filesystem::path& file) {
    const std::string text = file.filename().string();
    const auto percent = text.find('%');
    const auto end = text.find('d', percent);
    const auto digits = text.substr(percent + 1, end == std::string::npos ? end : end - percent - 1);
    const bool only_digits =
        std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c); });
    const bool zeros = digits.empty() || digits.front() == '0';
    if (end == std::string::npos || !only_digits || !zeros || digits.size() > 3 ||
        text.find('%', end) != std::string::npos)
        throw InputError{file.string() + ": unknown pattern; expected one %d or %05d in the name"};
    return {text.substr(0, percent), text.substr(end + 1), digits.empty() ? 0 : std::stoul(digits)};
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
    return file.has_parent_path() ? file.parent_path() : std::filesystem::path{"."};
}

/// True for a folder, and for a pattern of names.
bool are_images(const std::filesystem::path& file) {
    const bool pattern =
        file.filename().string().find('%') != std::string::npos && !std::filesystem::exists(file);
    return pattern || std::filesystem::is_directory(file);
}

std::vector<std::filesystem::path> images_like(const std::filesystem::path& file, MissingNumbers missing) {
    const Pattern pattern = parsed_pattern(file);
    const auto folder = folder_of(file);
    if (!std::filesystem::is_directory(folder)) throw InputError{folder.string() + ": No such folder"};
    std::map<std::int64_t, std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        if (const auto number = pattern.number(entry.path().filename().string()))
            found[*number] = entry.path();
    if (found.empty()) throw InputError{file.string() + ": no file matches this pattern"};
    std::vector<std::filesystem::path> files;
    std::int64_t expected = found.begin()->first;
    for (const auto& [number, path] : found) {
        if (number != expected && missing == MissingNumbers::refused)
            throw InputError{(folder / pattern.name(expected)).string() + ": is missing, but " +
                             path.filename().string() + " exists; if pictures were lost, set `times`"};
        files.push_back(path);
        expected = number + 1;
    }
    return files;
}

}  // namespace

void unpack_pixels(const std::vector<std::byte>& packed, unsigned bits, std::vector<std::byte>& pixels) {
    std::uint32_t window = 0;
    unsigned held = 0;
    std::size_t at = 0;
    for (std::size_t i = 0; i + 1 < pixels.size(); i += 2) {
        while (held < bits) {
            window = (window << 8U) | std::to_integer<std::uint32_t>(packed[at++]);
            held += 8;
        }
        held -= bits;
        const auto grey = static_cast<std::uint16_t>((window >> held) & ((1U << bits) - 1U));
        std::memcpy(&pixels[i], &grey, sizeof grey);
    }
}

std::unique_ptr<Media> open_movie(const std::filesystem::path& file) { return std::make_unique<Movie>(file); }

std::unique_ptr<Media> open_images(const std::filesystem::path& file, MissingNumbers missing) {
    const bool folder = std::filesystem::is_directory(file);
    return std::make_unique<Images>(folder ? images_in(file) : images_like(file, missing));
}

std::vector<std::filesystem::path> media_files(const std::filesystem::path& file) {
    if (!are_images(file)) {
        std::vector<std::filesystem::path> files{file};
        if (lower(file.extension().string()) == ".cih")
            for (const char* extension : raw_extensions)
                files.push_back(std::filesystem::path{file}.replace_extension(extension));
        return files;
    }
    const bool folder = std::filesystem::is_directory(file);
    std::vector<std::filesystem::path> files{folder ? file : folder_of(file)};
    try {
        for (auto& image : folder ? images_in(file) : images_like(file, MissingNumbers::left_out))
            files.push_back(std::move(image));
    } catch (const std::exception&) {  // reported when it is opened
    }
    return files;
}

void load_decoders() noexcept {
    try {
        (void)codecs::has_ffmpeg();
    } catch (const std::exception&) {  // reported when it is needed
    }
}

std::unique_ptr<Media> open_media(const std::filesystem::path& file, MissingNumbers missing) {
    const std::string extension = lower(file.extension().string());
    if (are_images(file)) return open_images(file, missing);
    if (!std::filesystem::exists(file)) throw InputError{file.string() + ": No such file or directory"};
    if (extension == ".cih") return open_photron(file);
    if (extension == ".cine") return open_phantom(file);
    if (extension == ".mraw" || extension == ".cihx")
        throw InputError{file.string() +
                         ": give the text header of this Photron recording, its .cih file, instead"};
    return open_movie(file);
}

}  // namespace shaker::footage
