#include "tests/support/tracking/peers.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace shaker::test {
namespace {

constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
constexpr int reach = 12;       // px, of a search about the last place
constexpr int dot_window = 29;  // px

cv::Mat grey(const Shot& shot) {
    return {shot.height, shot.width, CV_8UC1, const_cast<std::byte*>(shot.pixels.data()),
            static_cast<std::size_t>(shot.stride)};
}

cv::Rect region(const TrackingScene& scene) {
    const auto& r = scene.view.targets.front().roi_px;
    return {r[0], r[1], r[2], r[3]};
}

// The region of frame 0, searched within `reach` of its last position; peak by a parabola.
Peer match_template(cv::Rect start) {
    cv::Mat pattern, score;
    int x = start.x;
    return {"matchTemplate + parabola", [=](const Shot& shot) mutable {
                const cv::Mat picture = grey(shot);
                if (pattern.empty()) pattern = picture(start).clone();
                const int x0 = std::max(0, x - reach), x1 = std::min(shot.width, x + start.width + reach);
                cv::matchTemplate(picture(cv::Rect{x0, start.y, x1 - x0, start.height}), pattern, score,
                                  cv::TM_CCOEFF_NORMED);
                cv::Point best;
                cv::minMaxLoc(score, nullptr, nullptr, nullptr, &best);
                x = x0 + best.x;
                if (best.x < 1 || best.x + 1 >= score.cols) return nowhere;
                const float* s = score.ptr<float>(0) + best.x;
                const double left = s[-1], here = s[0], right = s[1];
                return x - start.x + 0.5 * (left - right) / (left - 2 * here + right);
            }};
}

// From the last place, as a tracker would start it.
Peer transform_ecc(cv::Rect start) {
    cv::Mat pattern, warp = cv::Mat::eye(2, 3, CV_32F);
    return {"findTransformECC", [=](const Shot& shot) mutable {
                const cv::Mat picture = grey(shot);
                if (pattern.empty()) pattern = picture(start).clone();
                const int x0 = std::max(0, start.x - reach),
                          x1 = std::min(shot.width, start.x + start.width + reach);
                warp.at<float>(0, 2) += static_cast<float>(start.x - x0);
                try {
                    cv::findTransformECC(pattern, picture(cv::Rect{x0, start.y, x1 - x0, start.height}), warp,
                                         cv::MOTION_TRANSLATION,
                                         {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-6});
                } catch (const cv::Exception&) {  // it does not converge
                    warp = cv::Mat::eye(2, 3, CV_32F);
                    return nowhere;
                }
                warp.at<float>(0, 2) -= static_cast<float>(start.x - x0);
                return static_cast<double>(warp.at<float>(0, 2));
            }};
}

Peer phase_correlation(cv::Rect start) {
    cv::Mat pattern, window, now;
    return {"phaseCorrelate, Hann", [=](const Shot& shot) mutable {
                grey(shot)(start).convertTo(now, CV_64F);
                if (pattern.empty()) {
                    pattern = now.clone();
                    cv::createHanningWindow(window, start.size(), CV_64F);
                }
                return cv::phaseCorrelate(pattern, now, window).x;
            }};
}

double middle_level(const cv::Mat& picture) {
    cv::Mat black_white;
    return cv::threshold(picture, black_white, 0, 255, cv::THRESH_BINARY + cv::THRESH_OTSU);
}

// The threshold of frame 0; the window follows the target in whole pixels.
Peer moments(cv::Rect start, bool dark) {
    cv::Mat blob;
    double level = 0, origin = 0;
    int x = start.x;
    return {"threshold + moments", [=](const Shot& shot) mutable {
                const cv::Mat picture = grey(shot);
                const bool first = level == 0;
                if (first) level = middle_level(picture(start));
                const int x0 = std::clamp(x, 0, shot.width - start.width);
                cv::threshold(picture(cv::Rect{x0, start.y, start.width, start.height}), blob, level, 255,
                              dark ? cv::THRESH_BINARY_INV : cv::THRESH_BINARY);
                const cv::Moments m = cv::moments(blob, true);
                if (!(m.m00 > 0)) return nowhere;
                const double at = x0 + m.m10 / m.m00;
                if (first) origin = at;
                x = start.x + static_cast<int>(std::lround(at - origin));
                return at - origin;
            }};
}

cv::Point2f whole(tracking::Point p) {
    return {static_cast<float>(std::lround(p.x)), static_cast<float>(std::lround(p.y))};
}

cv::Mat window_at(const Shot& shot, cv::Point2f middle) {
    cv::Mat window;
    cv::getRectSubPix(grey(shot), {dot_window, dot_window}, middle, window, CV_32F);
    return window;
}

// Centroid of what is darker than the middle level, each pixel as 1 or by how dark it is.
DotPeer centroid(bool weighted) {
    return {weighted ? "intensity-weighted centroid" : "threshold + centroid",
            [weighted](const Shot& shot, const DotPlaces& expected) {
                DotPlaces all;
                for (const tracking::Point p : expected) {
                    const cv::Point2f middle = whole(p);
                    cv::Mat window = window_at(shot, middle), grey8;
                    window.convertTo(grey8, CV_8U);
                    const double level = middle_level(grey8);
                    cv::Mat dark = level - window;
                    cv::threshold(dark, dark, 0, 1, weighted ? cv::THRESH_TOZERO : cv::THRESH_BINARY);
                    const cv::Moments m = cv::moments(dark);
                    const double half = 0.5 * (dot_window - 1);
                    all.push_back({middle.x - half + m.m10 / m.m00, middle.y - half + m.m01 / m.m00});
                }
                return all;
            }};
}

cv::Point2f float_of(tracking::Point p) { return {static_cast<float>(p.x), static_cast<float>(p.y)}; }

// Lucas-Kanade on two windows of one size; `from`: place in the first, `to`: expected in the second.
tracking::Point flow(const cv::Mat& first, cv::Point2f from, const cv::Mat& second, cv::Point2f to) {
    std::vector<cv::Point2f> then{from}, now{to};
    std::vector<unsigned char> seen;
    std::vector<float> error;
    cv::calcOpticalFlowPyrLK(first, second, then, now, seen, error, {dot_window, dot_window}, 0,
                             {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-4},
                             cv::OPTFLOW_USE_INITIAL_FLOW);
    if (seen.front() == 0) return {nowhere, nowhere};
    return {now.front().x, now.front().y};
}

DotPeer lucas_kanade(const Shot& first, const DotPlaces& dots) {
    return {"Lucas-Kanade", [first, dots](const Shot& shot, const DotPlaces& expected) {
                DotPlaces all;
                for (std::size_t k = 0; k < dots.size(); ++k)
                    all.push_back(flow(grey(first), float_of(dots[k]), grey(shot), float_of(expected[k])));
                return all;
            }};
}

// Lucas-Kanade against the mean of all pictures of a dot, which has less noise than the first.
DotPeer learned_template(const std::vector<Shot>& movie, const std::vector<DotPlaces>& places) {
    constexpr int size = 2 * dot_window + 1;
    std::vector<cv::Mat> means;
    for (std::size_t k = 0; k < places.front().size(); ++k) {
        cv::Mat sum = cv::Mat::zeros(size, size, CV_32F), one;
        for (std::size_t i = 0; i < movie.size(); ++i) {
            cv::getRectSubPix(grey(movie[i]), {size, size}, float_of(places[i][k]), one, CV_32F);
            sum += one;
        }
        cv::Mat mean;
        sum.convertTo(mean, CV_8U, 1.0 / static_cast<double>(movie.size()));
        means.push_back(mean);
    }
    return {"learned mean template", [means](const Shot& shot, const DotPlaces& expected) {
                DotPlaces all;
                const float half = 0.5F * (size - 1);
                for (std::size_t k = 0; k < means.size(); ++k) {
                    const cv::Point2f middle = whole(expected[k]), off = float_of(expected[k]) - middle;
                    cv::Mat window;
                    cv::getRectSubPix(grey(shot), {size, size}, middle, window);
                    const tracking::Point at =
                        flow(means[k], {half, half}, window, cv::Point2f{half, half} + off);
                    all.push_back({middle.x - half + at.x, middle.y - half + at.y});
                }
                return all;
            }};
}

}  // namespace

std::vector<Peer> peers_of(const TrackingScene& scene) {
    const Target& target = scene.view.targets.front();
    const cv::Rect start = region(scene);
    std::vector<Peer> peers{match_template(start), transform_ecc(start), phase_correlation(start)};
    const bool blob = target.kind == TargetKind::disc || target.kind == TargetKind::rectangle ||
                      (target.kind == TargetKind::dots && !(target.pitch_mm > 0));
    if (blob) peers.push_back(moments(start, target.polarity == Polarity::dark));
    return peers;
}

std::vector<DotPeer> dot_peers(const std::vector<Shot>& movie, const std::vector<DotPlaces>& places) {
    return {centroid(false), centroid(true), lucas_kanade(movie.front(), places.front()),
            learned_template(movie, places)};
}

}  // namespace shaker::test
