#pragma once
// What shaker_codecs.so gives to the program: the functions of codecs.hpp.
#include <chrono>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "drivers/codecs/codecs.hpp"

namespace shaker::codecs {

struct Functions {
    std::vector<Marker> (*find_markers)(const std::vector<unsigned char>&, int, int);
    std::unique_ptr<cv::VideoCapture> (*new_capture)();
    std::unique_ptr<cv::VideoWriter> (*open_ffv1)(const std::string&, double, cv::Size);
    bool (*has_ffmpeg)();
    bool (*wait_for_picture)(const cv::VideoCapture&, std::chrono::nanoseconds);
    cv::Mat (*read_image)(const std::string&);
    std::vector<unsigned char> (*jpeg_of)(const cv::Mat&, int);
};

/// The module's one exported symbol is of this type: `extern "C"`, named "shaker_codecs".
using GetFunctions = const Functions&();

}  // namespace shaker::codecs
