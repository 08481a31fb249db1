#pragma once
// A strip of bars across an axis: mean profiles of its bands, and the parts of it that are visible.
#include <span>
#include <vector>

#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// Mean profiles of a strip's rows, in bands of equal height.
class StripProfiles {
public:
    /// The rows across0 <= j < across1 (columns for Axis::y) and the number of bands.
    void place(Axis axis, int across0, int across1, std::size_t bands);
    /// Reads first <= i < last along the axis, clipped to the image.
    void load(const ImageView& image, int first, int last);
    /// The `count` means of a band from place `first` on; nullptr if not all of them were read.
    [[nodiscard]] const float* at(std::size_t band, int first, int count) const noexcept;
    [[nodiscard]] std::span<const float> band(std::size_t i) const noexcept { return profiles_[i]; }
    [[nodiscard]] std::size_t bands() const noexcept { return profiles_.size(); }
    [[nodiscard]] int first() const noexcept { return first_; }
    [[nodiscard]] double middle_across() const noexcept { return 0.5 * (across0_ + across1_ - 1); }
    /// Standard deviation of a band's mean, from the differences of neighbouring rows: bars are uniform along
    /// their length, and variation there is noise (or dirt, which only increases the error). Measured in
    /// every eighth picture.
    double noise(const ImageView& image);

private:
    Axis axis_ = Axis::x;
    int across0_ = 0, across1_ = 0, first_ = 0;
    std::vector<std::vector<float>> profiles_;
    double noise_ = 0;
    int noise_age_ = 0;  // pictures

    [[nodiscard]] double noise_in(const ImageView& image) const;
};

/// A part of a strip in one picture, compared with frame 0.
struct StripPart {
    double gain = 0, gain_sd = 0;  // contrast over that in frame 0
    double off = 0, off_sd = 0;    // px
    double weight = 0;             // proportional to 1 / off_sd^2
    bool used = false;
    bool apart = false;  // as good as the others, and elsewhere
};

/// Excludes parts whose contrast or place differs from the others' by more than noise; `slack`: px by which
/// places may differ beside noise. Leaves `used` true for the others; sets `apart` for those whose place
/// alone differs.
void exclude_hidden(std::span<StripPart> parts, double slack, std::vector<double>& scratch);

/// Weighted mean of the used parts: those of the first band, then of the next, `places` in each.
struct StripMean {
    double used = 0, weight = 0, off = 0, gain = 0;  // gain: sum over the used parts
    double places = 0;                               // where a part is used
    /// How much the parts, or the means over the bands at their places, scatter about their mean, over what
    /// their noise now and in frame 0 explains; at least 1. What the bands have in common is no noise.
    double excess = 1;
    double apart = 0;  // px, by which the place is in doubt for parts that are as good and elsewhere
};
StripMean mean_of(std::span<const StripPart> parts, std::size_t places);

}  // namespace shaker::tracking
