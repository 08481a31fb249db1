#pragma once
// Locator for periodic bars: phase of their fundamental.
#include <Eigen/Core>
#include <complex>

#include "tracking/image/region.hpp"
#include "tracking/image/strip.hpp"
#include "tracking/locator.hpp"

namespace shaker::tracking {

/// Position = pitch * phase / 2 pi of the fundamental, from overlapping Hann windows of three periods that
/// follow the bars in whole pixels. Each window is compared with its own phase in frame 0; hidden windows are
/// excluded. Measures along the image axis nearest to the shaker's; the other coordinate is the region's
/// middle. Bars are periodic: a frame is unambiguous only within half a pitch of the prediction, and after a
/// loss the search covers half a pitch around the last position.
class BarsLocator final : public Locator {
public:
    explicit BarsLocator(Subject subject);
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 0.4 * pitch_; }
    [[nodiscard]] double extent() const noexcept override { return 0.5 * pitch_; }
    [[nodiscard]] double pitch() const noexcept override { return pitch_; }
    [[nodiscard]] std::optional<Correction> correction() const override {
        return correction_of("pitch_mm", subject_.target.pitch_mm,
                             crossing_px(subject_, subject_.target.pitch_mm), pitch_);
    }
    [[nodiscard]] bool interchangeable() const noexcept override { return false; }

private:
    using Complex = std::complex<double>;
    struct Window {
        double centre = 0;  // in frame 0
        std::size_t band = 0;
        int first = 0;               // pixel of the first weight, in frame 0
        Eigen::MatrixX2f weights{};  // real and imaginary part
        Complex learned{}, now{};    // fundamental in frame 0 and in this one
        double learned_strength = 0;
    };

    void tabulate(Window& w) const;
    [[nodiscard]] Complex look(const Window& w, int moved) const;
    [[nodiscard]] Complex fundamental(std::size_t band, double centre, double pitch, double periods) const;
    double refine_pitch(double middle, double guess, double range) const;
    double strongest_pitch(double middle) const;
    bool measure(const ImageView& image, double shift, Candidate& out);

    Subject subject_;
    Axis axis_;
    double pitch_;
    Point learned_;
    std::vector<Window> windows_;
    std::vector<StripPart> parts_;  // the windows in this picture; off: beside their whole pixels
    StripProfiles profiles_;
    std::vector<double> scratch_;
};

}  // namespace shaker::tracking
