#pragma once
// Locator: interface of the measurement of one kind of target in a frame.
#include <memory>
#include <optional>
#include <vector>

#include "drivers/view.hpp"
#include "tracking/image/pixels.hpp"
#include "tracking/image/region.hpp"

namespace shaker::tracking {

/// Share by which a length in the settings may be wrong: it is measured then.
inline constexpr double wrong_size = 0.04;

/// A possible position of a target. Candidates that do not resemble the target in frame 0 are not reported.
struct Candidate {
    Point at;
    double sd = 0;          // px, along the shaker's axis
    double doubt = 0;       // px, standard error by the doubts, beside sd
    bool degraded = false;  // partly hidden or blurred, or its body turns
    bool mixed = false;     // it may be one of its neighbours
    double likeness = 0;    // 0..1, share of the target's outline or texture that is visible
};

/// How much of a picture a search covers. share: the next part of it, in bounded time; searches of the
/// following pictures cover the rest.
enum class Sweep { whole, share };

/// Finds one target in a frame, from its appearance in frame 0. Not thread-safe.
class Locator {
public:
    virtual ~Locator() = default;
    /// Position of the target in frame 0. Throws InputError when it is not in its region.
    virtual Point learn(const ImageView& image) = 0;
    /// Measures the target within reach() of `predicted`; false when it is not found.
    virtual bool locate(const ImageView& image, Point predicted, Candidate& out) = 0;
    /// Appends every position that resembles the target, best first. `last`: its last known position, which a
    /// share always covers; periodic kinds search only half a pitch around it.
    virtual void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) = 0;
    /// Largest error of a prediction for locate(), px.
    [[nodiscard]] virtual double reach() const noexcept = 0;
    /// Two positions closer than this are the same object, px.
    [[nodiscard]] virtual double extent() const noexcept = 0;
    /// Distance of the repeats of a periodic target, px; 0: the target is not periodic.
    [[nodiscard]] virtual double pitch() const noexcept { return 0; }
    /// The length that is used instead of the one in the settings.
    [[nodiscard]] virtual std::optional<Correction> correction() const { return {}; }
    /// True if two targets of this kind could be mistaken for each other.
    [[nodiscard]] virtual bool interchangeable() const noexcept = 0;
};

/// The locators of the kinds, each in its file. Throw InputError as make_locator().
std::unique_ptr<Locator> make_bars_locator(Subject subject);
std::unique_ptr<Locator> make_code_locator(Subject subject);
std::unique_ptr<Locator> make_disc_locator(Subject subject);
std::unique_ptr<Locator> make_dots_locator(Subject subject);
std::unique_ptr<Locator> make_patch_locator(Subject subject);
std::unique_ptr<Locator> make_rectangle_locator(Subject subject);

/// The locator for view.targets[index]. Throws InputError if a length or direction that the kind requires is
/// missing.
std::unique_ptr<Locator> make_locator(const View& view, std::size_t index);

}  // namespace shaker::tracking
