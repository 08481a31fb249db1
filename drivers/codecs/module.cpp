// The module shaker_codecs.so.
#include <opencv2/aruco.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>

#include "drivers/codecs/codecs.hpp"

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

std::vector<cv::Mat> read_pages(const std::string& file, std::int64_t first, std::int64_t count) {
    std::vector<cv::Mat> pages;
    if (first == 0 && count == 1)
        pages.push_back(cv::imread(file, cv::IMREAD_UNCHANGED));
    else
        cv::imreadmulti(file, pages, static_cast<int>(first), static_cast<int>(count), cv::IMREAD_UNCHANGED);
    return pages;
}

std::vector<unsigned char> jpeg_of(const cv::Mat& grey, int quality) {
    std::vector<unsigned char> jpeg;
    if (!cv::imencode(".jpg", grey, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality})) return {};
    return jpeg;
}

std::vector<Marker> find_markers(const std::vector<unsigned char>& grey, int width, int height) {
    const cv::Mat picture{height, width, CV_8U,
                          const_cast<unsigned char*>(grey.data())};  // NOLINT: only read
    const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_250);
    const auto settings = cv::aruco::DetectorParameters::create();
    constexpr double smallest = 0.01;  // circumference of a marker over the larger side of the picture
    settings->minMarkerPerimeterRate = smallest;
    settings->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;
    std::vector<int> numbers;
    std::vector<std::vector<cv::Point2f>> corners;
    cv::aruco::detectMarkers(picture, dictionary, corners, numbers, settings);
    std::vector<Marker> found(numbers.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        found[i].number = numbers[i];
        for (std::size_t k = 0; k < found[i].corners_px.size(); ++k)
            found[i].corners_px[k] = {corners[i][k].x, corners[i][k].y};
    }
    return found;
}

constexpr Functions functions{find_markers, new_capture, open_ffv1,  has_ffmpeg, wait_for_picture,
                              movie_stamps, image_pages, read_pages, jpeg_of};

}  // namespace
}  // namespace shaker::codecs

extern "C" const shaker::codecs::Functions& shaker_codecs() { return shaker::codecs::functions; }
