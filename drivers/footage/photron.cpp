#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <map>

#include "drivers/errors.hpp"
#include "drivers/footage/csv.hpp"
#include "drivers/footage/media.hpp"
#include "drivers/quantity.hpp"

namespace shaker::footage {
namespace {

/// The "key : value" lines up to the first END; later lines repeat them for older saves of the same
/// recording.
class Header {
public:
    explicit Header(const std::filesystem::path& file) : file_{file.string()} {
        std::ifstream in{file, std::ios::binary};
        if (!in) throw InputError{file_ + ": cannot be opened: " + std::strerror(errno)};
        for (std::string line; std::getline(in, line) && trimmed(line) != "END";) {
            const auto colon = line.find(':');
            if (colon == std::string::npos) continue;
            values_.try_emplace(std::string{trimmed(std::string_view{line}.substr(0, colon))},
                                trimmed(std::string_view{line}.substr(colon + 1)));
        }
    }
    [[nodiscard]] const std::map<std::string, std::string>& values() const noexcept { return values_; }
    [[nodiscard]] bool has(const std::string& key) const { return values_.contains(key); }
    [[nodiscard]] std::string text(const std::string& key) const {
        const auto found = values_.find(key);
        if (found == values_.end()) throw InputError{file_ + ": \"" + key + "\" is missing in this header"};
        return found->second;
    }
    [[nodiscard]] double number(const std::string& key, Range allowed) const {
        const std::string value = text(key);
        double result = 0;
        const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), result);
        const bool whole_text = error == std::errc{} && end == value.data() + value.size();
        if (!whole_text || !(result >= allowed.min && result <= allowed.max))
            throw InputError{file_ + ": \"" + key + " : " + value + "\" is not allowed: expected a number, " +
                             to_text(allowed)};
        return result;
    }
    [[nodiscard]] std::int64_t integer(const std::string& key, Range allowed) const {
        return static_cast<std::int64_t>(number(key, allowed));
    }
    void require(const std::string& key, std::initializer_list<std::string_view> allowed) const {
        std::string value = text(key), list;
        std::transform(value.begin(), value.end(), value.begin(),
                       [](unsigned char c) { return std::tolower(c); });
        for (const auto word : allowed) {
            if (value == word) return;
            list += (list.empty() ? "\"" : " or \"") + std::string{word} + "\"";
        }
        throw InputError{file_ + ": \"" + key + " : " + text(key) + "\" is not supported: expected " + list};
    }

private:
    std::string file_;
    std::map<std::string, std::string> values_;
};

bool may_change_rate(const std::string& key) {
    constexpr std::array read{"Record Rate(fps)", "Save Step"};
    constexpr std::array words{"step", "skip", "rate"};
    const std::string name = lower(key);
    const auto has = [&](const char* word) { return name.find(word) != std::string::npos; };
    return std::find(read.begin(), read.end(), key) == read.end() &&
           std::any_of(words.begin(), words.end(), has);
}

class Photron final : public Media {
public:
    explicit Photron(const std::filesystem::path& cih) {
        const Header header{cih};
        header.require("File Format", {"mraw"});
        header.require("Color Type", {"mono"});
        format_.width = static_cast<int>(header.integer("Image Width", {1, 65536}));
        format_.height = static_cast<int>(header.integer("Image Height", {1, 65536}));
        count_ = header.integer("Total Frame", {1, 1e9});
        rate_hz_ = header.number("Record Rate(fps)", {1e-3, 1e8});
        if (header.has("Save Step")) {
            const std::int64_t step = header.integer("Save Step", {1, 1e9});
            rate_hz_ /= static_cast<double>(step);
            if (step > 1)
                notes_.push_back(cih.string() + ": \"Save Step : " + std::to_string(step) + "\": of " +
                                 std::to_string(step) + " exposures one was saved, so that there are " +
                                 to_text(rate_hz_) + " pictures/s");
        }
        for (const auto& [key, value] : header.values())
            if (may_change_rate(key) && value != "0" && value != "1")
                notes_.push_back(cih.string() + ": \"" + key + " : " + value +
                                 "\" may change the rate of the pictures and is not read");
        bits_ = static_cast<unsigned>(header.integer("Color Bit", {8, 16}));
        if (bits_ != 8 && bits_ != 10 && bits_ != 12 && bits_ != 16)
            throw InputError{cih.string() + ": \"Color Bit : " + std::to_string(bits_) +
                             "\" is not supported: expected 8, 10, 12 or 16"};
        format_.bytes_per_pixel = bits_ == 8 ? 1 : 2;
        open_pictures(cih);
    }
    [[nodiscard]] PictureFormat format() const override { return format_; }
    [[nodiscard]] std::optional<double> rate_hz() const override { return rate_hz_; }
    [[nodiscard]] std::optional<std::int64_t> count() const override { return count_; }
    [[nodiscard]] std::vector<std::string> notes() const override { return notes_; }
    bool next(Picture& picture) override {
        if (next_ == count_) return false;
        picture.number = next_;
        picture.pixels.resize(pixels() * static_cast<std::size_t>(format_.bytes_per_pixel));
        auto& raw = packed() ? packed_ : picture.pixels;
        in_.read(reinterpret_cast<char*>(raw.data()), static_cast<std::streamsize>(raw.size()));
        if (!in_) throw InputError{mraw_.string() + ": picture " + std::to_string(next_) + " cannot be read"};
        if (packed()) unpack_pixels(packed_, bits_, picture.pixels);
        ++next_;
        return true;
    }

private:
    [[nodiscard]] bool packed() const { return bits_ == 10 || bits_ == 12; }
    [[nodiscard]] std::size_t pixels() const {
        return static_cast<std::size_t>(format_.width) * static_cast<std::size_t>(format_.height);
    }

    /// Checks the size of the pictures' file against the header before allocating memory.
    void open_pictures(const std::filesystem::path& cih) {
        mraw_ = cih;
        for (const char* extension : raw_extensions)
            if (std::filesystem::exists(mraw_.replace_extension(extension))) break;
        in_.open(mraw_, std::ios::binary);
        if (!in_)
            throw InputError{mraw_.replace_extension(".mraw").string() +
                             ": cannot be opened: " + std::strerror(errno) +
                             " (it must be in the same folder as " + cih.filename().string() + ")"};
        const std::uint64_t bits = std::uint64_t{pixels()} * bits_;
        if (bits % 8 != 0)
            throw InputError{cih.string() + ": pictures of " + std::to_string(format_.width) + " x " +
                             std::to_string(format_.height) + " pixels of " + std::to_string(bits_) +
                             " bits are not a whole number of bytes"};
        const std::uint64_t there = std::filesystem::file_size(mraw_);
        const std::uint64_t complete = there / (bits / 8);
        if (complete < static_cast<std::uint64_t>(count_))
            throw InputError{mraw_.string() + ": is cut short: " + std::to_string(there) + " bytes hold " +
                             std::to_string(complete) + " pictures, " + cih.filename().string() +
                             " promises " + std::to_string(count_)};
        if (packed()) packed_.resize(bits / 8);
    }

    PictureFormat format_;
    unsigned bits_ = 8;
    std::int64_t count_ = 0, next_ = 0;
    double rate_hz_ = 0;
    std::vector<std::string> notes_;
    std::filesystem::path mraw_;
    std::ifstream in_;
    std::vector<std::byte> packed_;
};

}  // namespace

std::unique_ptr<Media> open_photron(const std::filesystem::path& cih) {
    return std::make_unique<Photron>(cih);
}

}  // namespace shaker::footage
