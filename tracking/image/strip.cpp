#include "tracking/image/strip.hpp"

#include <algorithm>
#include <cmath>

#include "tracking/image/profile.hpp"

namespace shaker::tracking {
namespace {

constexpr int noise_every = 8;       // pictures
constexpr int noise_samples = 1000;  // pairs of pixels; the noise is then known to 2 %

}  // namespace

void StripProfiles::place(Axis axis, int across0, int across1, std::size_t bands) {
    axis_ = axis;
    across0_ = across0;
    across1_ = across1;
    profiles_.resize(bands);
    noise_age_ = 0;
}

void StripProfiles::load(const ImageView& image, int first, int last) {
    first_ = std::max(0, first);
    const int end = std::min(length_along(image, axis_), last), rows = across1_ - across0_;
    const auto bands = static_cast<int>(profiles_.size());
    for (int b = 0; b < bands; ++b) {
        auto& profile = profiles_[static_cast<std::size_t>(b)];
        profile.resize(static_cast<std::size_t>(std::max(0, end - first_)));
        if (profile.empty()) continue;
        mean_profile(image, axis_, first_, across0_ + rows * b / bands, across0_ + rows * (b + 1) / bands,
                     std::span<float>{profile});
    }
}

const float* StripProfiles::at(std::size_t band, int first, int count) const noexcept {
    const int from = first - first_;
    if (from < 0 || from + count > static_cast<int>(profiles_[band].size())) return nullptr;
    return profiles_[band].data() + from;
}

double StripProfiles::noise(const ImageView& image) {
    if (noise_age_ == 0) noise_ = noise_in(image);
    noise_age_ = (noise_age_ + 1) % noise_every;
    return noise_;
}

double StripProfiles::noise_in(const ImageView& image) const {
    const double rows = (across1_ - across0_) / static_cast<double>(profiles_.size());
    if (across1_ - across0_ < 2) return 1 / std::sqrt(rows);
    const int all = static_cast<int>(profiles_.front().size()), end = first_ + all;
    const int step = std::max(3, all * (across1_ - across0_) / 2 / noise_samples);
    double sum = 0, n = 0;
    with_pixels(image, [&](auto pixels) {
        for (int j = across0_; j + 1 < across1_; j += 2) {
            for (int i = first_; i < end; i += step) {
                const double d = axis_ == Axis::x ? pixels.at(i, j) - pixels.at(i, j + 1)
                                                  : pixels.at(j, i) - pixels.at(j + 1, i);
                sum += d * d;
                n += 1;
            }
        }
    });
    return std::sqrt(std::max(0.5 * sum / std::max(n, 1.0), 1.0 / 12)) / std::sqrt(rows);
}

void exclude_hidden(std::span<StripPart> parts, double slack, std::vector<double>& scratch) {
    const auto nth = [&](std::size_t n) {
        const auto at = scratch.begin() + static_cast<std::ptrdiff_t>(n);
        std::nth_element(scratch.begin(), at, scratch.end());
        return *at;
    };
    scratch.clear();
    for (const StripPart& p : parts) scratch.push_back(p.gain);
    // The upper quartile: an object over the bars lowers their contrast and may cover most of them.
    const double typical = nth(scratch.size() * 3 / 4);
    scratch.clear();
    for (StripPart& p : parts) {
        p.used = p.gain > 4 * p.gain_sd && p.gain > 0.2 &&
                 std::abs(p.gain - typical) < 0.15 * typical + 4 * p.gain_sd;
        if (p.used) scratch.push_back(p.off);
    }
    if (scratch.empty()) return;
    const double middle = nth(scratch.size() / 2);
    for (StripPart& p : parts) {
        p.apart = p.used && !(std::abs(p.off - middle) < 5 * p.off_sd + slack);
        p.used = p.used && !p.apart;
    }
}

StripMean mean_of(std::span<const StripPart> parts, std::size_t places) {
    StripMean mean;
    double sum = 0, scatter = 0, apart = 0, all = 0;
    for (const StripPart& p : parts) {
        if (!p.used) continue;
        mean.used += 1;
        mean.weight += p.weight;
        sum += p.weight * p.off;
        mean.gain += p.gain;
    }
    if (!(mean.used > 0)) return mean;
    mean.off = sum / mean.weight;
    for (const StripPart& p : parts) {
        const double far = (p.off - mean.off) * (p.off - mean.off);
        if (p.used) scatter += far / (p.off_sd * p.off_sd);
        if (p.apart) apart += p.weight * far;
        if (p.used || p.apart) all += p.weight;
    }
    mean.apart = std::sqrt(apart / all);
    double common = 0;
    for (std::size_t k = 0; k < places; ++k) {
        double weight = 0, off = 0;
        for (std::size_t i = k; i < parts.size(); i += places) {
            if (!parts[i].used) continue;
            const double certainty = 1 / (parts[i].off_sd * parts[i].off_sd);
            weight += certainty;
            off += certainty * (parts[i].off - mean.off);
        }
        if (weight > 0) mean.places += 1, common += off * off / weight;
    }
    if (mean.used > 3) mean.excess = std::sqrt(std::max(1.0, scatter / (2 * (mean.used - 1))));
    if (mean.places > 1) mean.excess = std::max(mean.excess, std::sqrt(common / (2 * (mean.places - 1))));
    return mean;
}

}  // namespace shaker::tracking
