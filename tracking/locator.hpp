#pragma once
// What the tracker asks of every kind of target: how a frame is measured, apart from which target is which.
#include <memory>
#include <vector>

#include "drivers/view.hpp"
#include "tracking/pixels.hpp"

namespace shaker {

/// A place where a target may be. Quality has been tested already: what does not look like the target in
/// frame 0 is not reported.
struct Candidate {
    Point at;
    double sd = 0;          // px, along the shaker's axis
    bool degraded = false;  // part of it is hidden, saturated or blurred
    double likeness = 0;    // 0..1, share of the target's outline or texture that is there
};

/// Finds one target in a frame. Keeps what it learned in frame 0; not thread-safe.
class Locator {
public:
    virtual ~Locator() = default;
    /// The target's place in frame 0. Throws InputError when the region does not hold it.
    virtual Point learn(const ImageView& image) = 0;
    /// Measures the target within reach() of `predicted`; false when it is not there.
    virtual bool locate(const ImageView& image, Point predicted, Candidate& out) = 0;
    /// Appends every place in the view that looks like the target, best first. `last` is where it was seen
    /// last: kinds that repeat themselves look no further than half a pitch from it.
    virtual void search(const ImageView& image, Point last, std::vector<Candidate>& out) = 0;
    /// How far off a prediction may be, in px.
    [[nodiscard]] virtual double reach() const noexcept = 0;
    /// Two fixes nearer than this are the same thing, in px.
    [[nodiscard]] virtual double extent() const noexcept = 0;
    /// Whether two targets of this kind could take each other's place.
    [[nodiscard]] virtual bool interchangeable() const noexcept = 0;
};

/// The locator for view.targets[index]. Throws InputError for a length or a direction the kind cannot do
/// without.
std::unique_ptr<Locator> make_locator(const View& view, std::size_t index);

}  // namespace shaker
