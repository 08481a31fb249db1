// Numbered images, and images of several pages.
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <map>

#include "drivers/codecs/codecs.hpp"
#include "drivers/errors.hpp"
#include "drivers/footage/grey.hpp"
#include "drivers/footage/media.hpp"

namespace shaker::footage {
namespace {

/// Images, and the pages of each, in their order.
class Images final : public Media {
public:
    explicit Images(std::vector<std::filesystem::path> files) : files_{std::move(files)} {
        for (const std::filesystem::path& file : files_) {
            pages_.push_back(codecs::image_pages(file.string()));
            count_ += pages_.back();
        }
        format_ = format_of(grey_of(codecs::read_pages(files_.front().string(), 0, 1).front()));
    }
    [[nodiscard]] PictureFormat format() const override { return format_; }
    [[nodiscard]] std::optional<double> rate_hz() const override { return {}; }
    [[nodiscard]] std::optional<std::int64_t> count() const override { return count_; }
    bool next(Picture& picture) override {
        if (next_ == count_) return false;
        if (page_ == pages_.at(file_)) ++file_, page_ = 0;
        const std::string name = files_.at(file_).string();
        // A file is searched from its start for each call, so several pages are read at once.
        if (page_ % together == 0)
            held_ = codecs::read_pages(name, page_, std::min(together, pages_.at(file_) - page_));
        const cv::Mat grey = grey_of(held_.at(static_cast<std::size_t>(page_ % together)));
        const std::string page = pages_.at(file_) > 1 ? "page " + std::to_string(page_) : "this image";
        require_format(name + ": " + page, format_of(grey), format_);
        copy_pixels(grey, picture.pixels);
        picture.number = next_++;
        ++page_;
        return true;
    }

private:
    static constexpr std::int64_t together = 16;

    std::vector<std::filesystem::path> files_;
    std::vector<std::int64_t> pages_;
    PictureFormat format_;
    std::vector<cv::Mat> held_;
    std::size_t file_ = 0;
    std::int64_t page_ = 0, next_ = 0, count_ = 0;
};

bool is_image(const std::filesystem::path& file) {
    constexpr std::array extensions{".png", ".tif", ".tiff", ".pgm", ".pnm", ".bmp", ".jpg", ".jpeg"};
    return std::find(extensions.begin(), extensions.end(), lower(file.extension().string())) !=
           extensions.end();
}

/// macOS keeps properties of "img.png" in "._img.png".
bool is_hidden(const std::filesystem::path& file) { return file.filename().string().starts_with('.'); }

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
        if (entry.is_regular_file() && !is_hidden(entry.path()) && is_image(entry.path()))
            files.push_back(entry.path());
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

bool are_images(const std::filesystem::path& file) {
    const bool pattern =
        file.filename().string().find('%') != std::string::npos && !std::filesystem::exists(file);
    return pattern || std::filesystem::is_directory(file) || is_image(file);
}

std::vector<std::filesystem::path> image_files(const std::filesystem::path& file, MissingNumbers missing) {
    if (std::filesystem::is_directory(file)) return images_in(file);
    if (std::filesystem::exists(file)) return {file};
    return images_like(file, missing);
}

std::unique_ptr<Media> open_images(const std::filesystem::path& file, MissingNumbers missing) {
    return std::make_unique<Images>(image_files(file, missing));
}

}  // namespace shaker::footage
