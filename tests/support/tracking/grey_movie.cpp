#include "tests/support/tracking/grey_movie.hpp"

#include <cstring>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>

namespace shaker::test {

std::vector<Shot> grey_movie(const std::filesystem::path& file) {
    cv::VideoCapture movie{file.string()};
    std::vector<Shot> shots;
    cv::Mat colour, grey;
    while (movie.read(colour)) {
        cv::cvtColor(colour, grey, cv::COLOR_BGR2GRAY);
        Shot shot;
        shot.width = grey.cols;
        shot.height = grey.rows;
        shot.stride = grey.cols;
        shot.pixels.resize(grey.total());
        for (int y = 0; y < grey.rows; ++y) {
            std::memcpy(shot.pixels.data() + y * shot.stride, grey.ptr(y),
                        static_cast<std::size_t>(grey.cols));
        }
        shots.push_back(std::move(shot));
    }
    if (shots.empty()) throw std::runtime_error{"no frames in " + file.string()};
    return shots;
}

}  // namespace shaker::test
