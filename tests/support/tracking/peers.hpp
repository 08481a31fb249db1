#pragma once
// Other methods of tracking, each from OpenCV or a few lines, for comparison on the same pictures.
#include <functional>
#include <string>
#include <vector>

#include "tests/support/tracking/tracking_scene.hpp"

namespace shaker::test {

/// A method that follows the target of a scene. find: x since the first picture, px; NaN: not found.
struct Peer {
    std::string name;
    std::function<double(const Shot&)> find;
};

/// matchTemplate with a parabola, findTransformECC, phaseCorrelate with a Hann window; threshold and moments,
/// for kinds that are one blob.
std::vector<Peer> peers_of(const TrackingScene& scene);

/// Places of the dots in one picture, px, always in the same order.
using DotPlaces = std::vector<tracking::Point>;

/// A method that finds dark dots near the places where they are expected.
struct DotPeer {
    std::string name;
    std::function<DotPlaces(const Shot&, const DotPlaces& expected)> find;
};

/// Threshold and centroid, intensity-weighted centroid, Lucas-Kanade, Lucas-Kanade against a learned mean
/// template; on windows of 29 px. `places`: of each picture, to 1 px.
std::vector<DotPeer> dot_peers(const std::vector<Shot>& movie, const std::vector<DotPlaces>& places);

}  // namespace shaker::test
