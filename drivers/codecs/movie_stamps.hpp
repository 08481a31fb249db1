#pragma once
// What a movie's container states of its pictures, without decoding them.
#include <cstdint>
#include <optional>
#include <vector>

namespace shaker::codecs {

/// A faster movie does not exist: such a rate is the unit of its stamps.
inline constexpr double most_movie_hz = 1e5;

struct MovieStamps {
    /// Times of the pictures in the order of showing, s, as cv::CAP_PROP_POS_MSEC counts them. Empty: the
    /// file states none (a bare stream), or is no movie.
    std::vector<double> at_s;
    double resolution_s = 0;               // unit of the stamps
    std::optional<double> rate_hz;         // stated for all pictures
    std::optional<std::int64_t> promised;  // number of pictures in the index, where there is a true one
    std::optional<double> states_s;        // stated end of the longest stream, s, from the first picture
    bool alone = false;                    // there is no other stream than the pictures
    bool interlaced = false;               // a picture has two times, one for every second row
};

}  // namespace shaker::codecs
