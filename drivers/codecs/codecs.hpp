#pragma once
// Movies, video devices and image files by OpenCV. Its libraries for these (and the 200 that they need) take
// 0.2 s and more of a program's start, so they are linked to a module, shaker_codecs.so, that the first call
// here loads. Each function throws DeviceError where the module is missing. Any thread.
#include <array>
#include <chrono>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "drivers/codecs/movie_stamps.hpp"

namespace shaker::codecs {

/// Loads the module now, so that a program that lives through an upgrade keeps its own version.
void load_now();

/// A marker of OpenCV's dictionary DICT_4X4_250: corners of its dark frame from its own top left, clockwise,
/// px.
struct Marker {
    int number = 0;
    std::array<std::array<double, 2>, 4> corners_px{};
};
/// Markers in a grey picture of 8 bits, by rows.
std::vector<Marker> find_markers(const std::vector<unsigned char>& grey, int width, int height);

/// A capture that is not open yet. Its virtual functions may be called; no other part of OpenCV's video
/// input is linked to the program.
std::unique_ptr<cv::VideoCapture> new_capture();

/// A new movie of colour pictures in FFV1, by FFmpeg; null when it cannot be written.
std::unique_ptr<cv::VideoWriter> open_ffv1(const std::string& file, double rate_hz, cv::Size size);

/// Whether OpenCV reads movies by FFmpeg here.
bool has_ffmpeg();

/// Waits until an open V4L2 device has a picture: false when it has none after `wait`. Throws cv::Exception
/// when the device is gone.
bool wait_for_picture(const cv::VideoCapture& device, std::chrono::nanoseconds wait);

/// What a movie's container states of its pictures.
MovieStamps movie_stamps(const std::string& file);

/// Pages of an image file; 1 but for TIFF. InputError for more than a million pages, and for one of more than
/// 2^28 pixels. No pixel is read.
std::int64_t image_pages(const std::string& file);

/// Pages of an image file from `first` on, with their own channels, of 8 or 16 bits. InputError when one
/// cannot be decoded, or has other pixels.
std::vector<cv::Mat> read_pages(const std::string& file, std::int64_t first, std::int64_t count);

/// A grey picture of 8 bits as a JPEG file of this quality (0 to 100); empty when it cannot be encoded.
std::vector<unsigned char> jpeg_of(const cv::Mat& grey, int quality);

/// What shaker_codecs.so gives to the program: the functions above.
struct Functions {
    std::vector<Marker> (*find_markers)(const std::vector<unsigned char>&, int, int);
    std::unique_ptr<cv::VideoCapture> (*new_capture)();
    std::unique_ptr<cv::VideoWriter> (*open_ffv1)(const std::string&, double, cv::Size);
    bool (*has_ffmpeg)();
    bool (*wait_for_picture)(const cv::VideoCapture&, std::chrono::nanoseconds);
    MovieStamps (*movie_stamps)(const std::string&);
    std::int64_t (*image_pages)(const std::string&);
    std::vector<cv::Mat> (*read_pages)(const std::string&, std::int64_t, std::int64_t);
    std::vector<unsigned char> (*jpeg_of)(const cv::Mat&, int);
};

/// The module's one exported symbol is of this type: `extern "C"`, named "shaker_codecs".
using GetFunctions = const Functions&();

}  // namespace shaker::codecs
