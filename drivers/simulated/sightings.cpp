#include "drivers/simulated/sightings.hpp"

#include <random>

#include "drivers/simulated/true_view.hpp"

namespace shaker::simulated {

namespace {

// A generator whose state is a hash of the arguments (splitmix64).
std::minstd_rand generator(std::uint64_t seed, std::uint64_t tick) {
    std::uint64_t z = seed + 0x9e3779b97f4a7c15ULL * (tick + 1);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return std::minstd_rand{static_cast<std::uint_fast32_t>((z ^ (z >> 31U)) % 2147483646U + 1)};
}

}  // namespace

std::vector<Sighting> sightings(const CameraTruth& camera, const PictureLayout& layout,
                                std::span<const Pose> poses, CameraTick tick, bool walker,
                                std::uint64_t seed) {
    Pose mean{};
    for (const Pose& p : poses) {
        mean.base += p.base / static_cast<double>(poses.size());
        mean.walker += p.walker / static_cast<double>(poses.size());
    }
    std::minstd_rand random = generator(seed, static_cast<std::uint64_t>(tick.n));
    std::normal_distribution<double> noise{0, sighting_sd_px};
    std::vector<Sighting> found;
    const View truth = true_view(camera);
    found.reserve(camera.view.targets.size());
    for (const Target& target : camera.view.targets) {
        const bool base = target.name == "base";
        const double row = base ? 0.5 * (layout.marks_top + layout.marks_bottom) : layout.walker_y;
        const auto [x, y] = seen_at(truth, target.offset_mm, base ? mean.base : mean.walker, layout.centre_x,
                                    row, base ? layout.base_px_per_m : layout.walker_px_per_m);
        const Sighting s{x + noise(random), y + noise(random), sighting_sd_px};
        const bool seen = base || (walker && x >= 0 && x <= camera.width - 1);
        found.push_back(seen ? s : Sighting{});
    }
    return found;
}

}  // namespace shaker::simulated
