// Movies, decoded by OpenCV, with the stamps of their container.
#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "drivers/codecs/codecs.hpp"
#include "drivers/errors.hpp"
#include "drivers/footage/grey.hpp"
#include "drivers/footage/media.hpp"
#include "drivers/quantity.hpp"

namespace shaker::footage {
namespace {

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
        stated_ = codecs::movie_stamps(file_);
        if (!capture_->read(ahead_) || ahead_.empty())
            throw InputError{file_ + ": no picture of this movie can be decoded"};
        ahead_ = grey_of(ahead_).clone();
        format_ = format_of(ahead_);
    }
    [[nodiscard]] PictureFormat format() const override { return format_; }
    [[nodiscard]] std::optional<double> rate_hz() const override {
        if (stated_.at_s.empty()) return {};
        const double rate = capture_->get(cv::CAP_PROP_FPS);
        if (rate > 0.01 && rate < codecs::most_movie_hz) return rate;
        return stated_.rate_hz;
    }
    [[nodiscard]] std::optional<std::int64_t> count() const override { return {}; }
    [[nodiscard]] Stamps stamps() override { return {stated_.at_s, stated_.resolution_s}; }
    [[nodiscard]] std::vector<std::string> notes() const override {
        std::vector<std::string> all;
        if (deeper_than_8_bits(*capture_))
            all.push_back(file_ +
                          " has more than 8 bits per pixel, but only 8 can be read from a movie; numbered "
                          "16-bit images keep all");
        if (stated_.interlaced)
            all.push_back(file_ +
                          " is interlaced: every second row of a picture was exposed half a step later; "
                          "motion along a row is measured at the mean of the two times");
        if (!stated_.promised && !stated_.alone && lacks_s() > 0)
            all.push_back(file_ + ": its pictures end at " + to_text(stated_.at_s.back()) +
                          " s, its header states " + to_text(*stated_.states_s) +
                          " s: sound that is longer, or a file that is cut short");
        return all;
    }

    bool next(Picture& picture) override {
        if (ahead_.empty()) return false;
        copy_pixels(ahead_, picture.pixels);
        picture.number = number_;
        // A picture that cannot be decoded fails once; the end of the movie fails repeatedly.
        if (!capture_->read(ahead_) && !capture_->read(ahead_)) ahead_.release();
        if (ahead_.empty()) {
            require_end();
            return true;
        }
        ahead_ = grey_of(ahead_);
        require_format(file_ + ": picture " + std::to_string(number_ + 1), format_of(ahead_), format_);
        number_ = number_of_ahead();
        return true;
    }

private:
    /// OpenCV silently skips pictures that it cannot decode. Their stamps are left out.
    [[nodiscard]] std::int64_t number_of_ahead() const {
        const std::vector<double>& at_s = stated_.at_s;
        const double now_s = 1e-3 * capture_->get(cv::CAP_PROP_POS_MSEC);
        const auto near = std::lower_bound(at_s.begin(), at_s.end(), now_s - 0.5 * stated_.resolution_s);
        const std::int64_t found = near - at_s.begin();
        return near != at_s.end() && found > number_ ? found : number_ + 1;
    }

    void require_end() const {
        const std::vector<double>& at_s = stated_.at_s;
        const auto last = static_cast<std::int64_t>(at_s.size()) - 1;
        if (last < 0) return;
        std::string promises;
        if (const std::int64_t count = std::max(stated_.promised.value_or(0), last + 1); number_ + 1 < count)
            promises = std::to_string(count) + " pictures";
        else if (stated_.alone && !stated_.promised && lacks_s() > 0)
            promises = std::to_string(*stated_.states_s) + " s";
        if (promises.empty()) return;
        throw InputError{file_ + ": is cut short: picture " + std::to_string(number_) + " at " +
                         std::to_string(at_s.at(static_cast<std::size_t>(std::min(number_, last)))) +
                         " s is the last that can be decoded, the file promises " + promises};
    }

    /// Time from the last picture to the stated end, beyond a few steps, s; not positive when they agree.
    [[nodiscard]] double lacks_s() const {
        const std::vector<double>& at_s = stated_.at_s;
        if (at_s.size() < 2 || !stated_.states_s) return 0;
        constexpr double few = 3.5;
        return *stated_.states_s - at_s.back() - few * at_s.back() / static_cast<double>(at_s.size() - 1);
    }

    std::string file_;
    std::unique_ptr<cv::VideoCapture> capture_ = codecs::new_capture();
    codecs::MovieStamps stated_;
    cv::Mat ahead_;
    PictureFormat format_;
    std::int64_t number_ = 0;  // of the picture ahead
};

}  // namespace

std::unique_ptr<Media> open_movie(const std::filesystem::path& file) { return std::make_unique<Movie>(file); }

}  // namespace shaker::footage
