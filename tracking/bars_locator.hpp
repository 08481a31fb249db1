#pragma once
// Locator for periodic bars: phase of their fundamental.
#include <Eigen/Core>
#include <complex>

#include "tracking/image/profile.hpp"
#include "tracking/image/region.hpp"
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
    [[nodiscard]] bool interchangeable() const noexcept override { return false; }

private:
    using Complex = std::complex<double>;
    struct Window {
        double centre = 0;  // in frame 0
        std::size_t band = 0;
        int first = 0;                                       // pixel of the first weight, in frame 0
        Eigen::Matrix<double, Eigen::Dynamic, 2> weights{};  // real and imaginary part
        Complex learned{}, now{};                            // fundamental in frame 0 and in this one
        double learned_strength = 0, strength = 0;           // their moduli
        double off = 0;                                      // px, shift minus the whole pixels of the window
        bool used = false;
    };

    void tabulate(Window& w) const;
    [[nodiscard]] Complex look(const Window& w, int moved) const;
    [[nodiscard]] Complex fundamental(std::size_t band, double centre, double pitch, double periods) const;
    double refine_pitch(double middle, double guess, double range) const;
    double strongest_pitch(double middle) const;
    void load(const ImageView& image, int first, int last);
    [[nodiscard]] double row_noise(const ImageView& image) const;
    double median_off();
    void choose_windows(double noise);
    bool measure(const ImageView& image, double shift, Candidate& out);

    Subject subject_;
    Axis axis_;
    double pitch_;
    int across0_ = 0, across1_ = 0;
    Point learned_;
    std::vector<Window> windows_;
    std::vector<std::vector<double>> profiles_;  // one per band
    std::vector<double> sorted_;
    int profile_first_ = 0;
};

}  // namespace shaker::tracking
