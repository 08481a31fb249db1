// The module shaker_codecs.so.
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>

#include "drivers/codecs/functions.hpp"

namespace shaker::codecs {
namespace {

std::unique_ptr<cv::VideoCapture> new_capture() { return std::make_unique<cv::VideoCapture>(); }

std::unique_ptr<cv::VideoWriter> open_ffv1(const std::string& file, double rate_hz, cv::Size size) {
    auto movie = std::make_unique<cv::VideoWriter>();
    constexpr bool colour = true;
    if (!movie->open(file, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), rate_hz, size,
                     colour))
        return nullptr;
    return movie;
}

bool has_ffmpeg() { return cv::videoio_registry::hasBackend(cv::CAP_FFMPEG); }

bool wait_for_picture(const cv::VideoCapture& device, std::chrono::nanoseconds wait) {
    std::vector<int> which;
    return cv::VideoCapture::waitAny({device}, which, wait.count());
}

cv::Mat read_image(const std::string& file) { return cv::imread(file, cv::IMREAD_UNCHANGED); }

std::vector<unsigned char> jpeg_of(const cv::Mat& grey, int quality) {
    std::vector<unsigned char> jpeg;
    if (!cv::imencode(".jpg", grey, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality})) return {};
    return jpeg;
}

constexpr Functions functions{new_capture, open_ffv1, has_ffmpeg, wait_for_picture, read_image, jpeg_of};

}  // namespace
}  // namespace shaker::codecs

extern "C" const shaker::codecs::Functions& shaker_codecs() { return shaker::codecs::functions; }
