#include "tracking/tracker.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>

#include "drivers/errors.hpp"
#include "tracking/clipping.hpp"
#include "tracking/constellation.hpp"
#include "tracking/image/region.hpp"
#include "tracking/locator.hpp"
#include "tracking/old_rows.hpp"
#include "tracking/slip_watch.hpp"

namespace shaker::tracking {
namespace {

constexpr double enough_likeness = 0.85;  // above it, an unnamed object counts as a look-alike of a target
// A lost target must resemble itself so much better than anything else in frame 0 did.
constexpr double better_than_rivals = 0.05;
// A bright side that is clipped moves the place of an edge by up to this, px: measured at exposures that are
// up to three times too long.
constexpr double clipped_sd = 0.04;
// The same where less than this share of the outline is seen: edges then do not balance each other.
constexpr double balanced_likeness = 0.75, clipped_unbalanced_sd = 0.5;
// A larger error than this, px, says that the blocks of a clipped outline disagree: its edges moved apart.
constexpr double clipped_most_sd = 0.04;
// A locator looks again with care at what it has learned in one of so many pictures.
constexpr int most_clipped = 16;

struct Followed {
    std::unique_ptr<Locator> locator;
    std::string label;
    TargetKind kind{};
    SlipWatch slips;
    ClippingWatch clipping{};
    int clipped = 0;  // pictures, less those that came since
    Point at{}, velocity{};
    Box region{};       // in frame 0
    Point began{};      // place in frame 0
    bool seen = true;   // in the last frame
    double unseen = 0;  // pictures since it was seen whole, with those that never came
    bool in_group = false;
    // What resembled it in frame 0 and is not in its group: likeness of the best one, px to the farthest one.
    double rival = 0, farthest_rival = 0;
    [[nodiscard]] bool certain(const Candidate& found) const {
        return !found.degraded && !found.mixed && found.likeness > rival + better_than_rivals;
    }
};

// Look-alikes that are assigned together.
struct Group {
    std::vector<std::size_t> targets;
    Constellation constellation;
    std::vector<std::unique_ptr<Locator>> companions;  // of the unnamed members; empty: it cannot be learned
    /// Degrades a member that may bear another one's name.
    void doubt(Candidate& found) const {
        const double doubt = constellation.doubt_px();
        found.mixed = doubt > 0;
        found.doubt = std::hypot(found.doubt, doubt);
    }
};

}  // namespace

struct ViewTracker::Impl {
    View view;
    std::vector<Followed> targets;
    std::vector<Group> groups;
    OldRows old_rows;
    std::vector<Fix> fixes;
    std::vector<Candidate> candidates;
    std::int64_t last_tick = 0;
    int width = 0, height = 0;
    bool started = false;

    void start(const ImageView& image);
    void check_distinct() const;
    void find_groups(const ImageView& image);
    void follow_alone(const ImageView& image, std::size_t k, double frames);
    [[nodiscard]] std::unique_ptr<Locator> companion_of(std::size_t k, Point at,
                                                        const ImageView& image) const;
    bool follow_near(const ImageView& image, Group& group, double frames);
    void follow_group(const ImageView& image, Group& group, double frames);
    bool choose_by_distance(Point expected, Candidate& out) const;
    void part_claims(double frames);
    void report(const ImageView& image, std::size_t k, Candidate found, double frames);
    void lose(std::size_t k, double frames);
};

void ViewTracker::Impl::report(const ImageView& image, std::size_t k, Candidate found, double frames) {
    Followed& t = targets[k];
    if (!finite(found.at) || !std::isfinite(found.sd)) {
        lose(k, frames);
        return;
    }
    // A partly hidden target may be something else beside it: no evidence about slips.
    const bool partly = found.degraded || found.mixed;
    const int x = static_cast<int>(std::lround(found.at.x - t.began.x));
    const int y = static_cast<int>(std::lround(found.at.y - t.began.y));
    const Box& r = t.region;
    // What a locator has learned from clipped pictures stays in doubt for as many that follow.
    if (t.clipping.clipped(image, {r.x0 + x, r.y0 + y, r.x1 + x, r.y1 + y}, old_rows.noise_seen())) {
        t.clipped = std::min(t.clipped + 1, most_clipped);
        if (found.sd > clipped_most_sd) return lose(k, frames);
    } else {
        t.clipped = std::max(t.clipped - 1, 0);
    }
    const bool clipped = t.clipped > 0;
    if (clipped)
        found.sd =
            std::hypot(found.sd, found.likeness < balanced_likeness ? clipped_unbalanced_sd : clipped_sd);
    t.velocity = t.seen && frames > 0 ? (1 / frames) * (found.at - t.at) : Point{};
    t.at = found.at;
    const Point axis{view.along[0], view.along[1]};
    t.unseen += frames;
    std::optional<double> slip;
    if (!partly || t.rival > 0) {
        const bool certain = t.rival > 0 && t.certain(found);
        slip = t.slips.take(found.at.x * axis.x + found.at.y * axis.y, t.unseen, certain);
        t.unseen = 0;
    }
    const double doubt = t.slips.doubt_px();
    const double slipped =
        std::hypot(doubt > 0 ? std::max(doubt, 0.5 * t.farthest_rival) : 0, slip.value_or(0));
    const TrackState state = slipped > 0 || found.mixed ? TrackState::slipped
                             : clipped                  ? TrackState::clipped
                             : found.degraded           ? TrackState::degraded
                             : t.seen                   ? TrackState::ok
                                                        : TrackState::reacquired;
    fixes[k] = {found.at.x, found.at.y, std::hypot(found.sd, found.doubt, slipped), state};
    if (slip) t.at = t.at - *slip * axis;  // the next picture is searched at the true place
    t.seen = true;
}

void ViewTracker::Impl::lose(std::size_t k, double frames) {
    fixes[k] = {};
    targets[k].unseen += frames;
    targets[k].seen = false;
    targets[k].velocity = {};
}

void ViewTracker::Impl::start(const ImageView& image) {
    width = image.width;
    height = image.height;
    fixes.assign(view.targets.size(), {});
    targets.clear();
    groups.clear();
    for (std::size_t k = 0; k < view.targets.size(); ++k) {
        const Target& target = view.targets[k];
        auto locator = make_locator(view, k);
        const SlipWatch slips{locator->pitch(), target.name == "base"};
        Followed t{std::move(locator), subject_of(view, target).label, target.kind, slips};
        t.at = t.began = t.locator->learn(image);
        t.region = region_in(subject_of(view, view.targets[k]), image);
        targets.push_back(std::move(t));
        Candidate found;
        if (!targets[k].locator->locate(image, targets[k].at, found)) {
            throw InputError{targets[k].label + ": the target is too faint or too blurred to be measured"};
        }
        report(image, k, found, 0);
    }
    check_distinct();
    find_groups(image);
    started = true;
}

void ViewTracker::Impl::check_distinct() const {
    for (std::size_t k = 0; k < targets.size(); ++k) {
        for (std::size_t l = 0; l < k; ++l) {
            const Followed &a = targets[k], &b = targets[l];
            const double apart = 0.5 * std::min(a.locator->extent(), b.locator->extent());
            if (a.kind == b.kind && a.locator->interchangeable() && length(a.at - b.at) < apart) {
                throw InputError{a.label + ": found the same object as target " + view.targets[l].name +
                                 "; check both regions"};
            }
        }
    }
}

void ViewTracker::Impl::find_groups(const ImageView& image) {
    for (std::size_t k = 0; k < targets.size(); ++k) {
        Followed& t = targets[k];
        if (t.in_group || !t.locator->interchangeable()) continue;
        candidates.clear();
        t.locator->search(image, t.at, Sweep::whole, candidates);
        std::vector<std::size_t> members{k};
        std::vector<Point> places{t.at}, companions;
        double nearest = 1e9;
        for (const Candidate& c : candidates) {
            std::size_t owner = targets.size();
            for (std::size_t l = 0; l < targets.size(); ++l) {
                const bool here = length(targets[l].at - c.at) < 0.5 * targets[l].locator->extent();
                if (targets[l].kind == t.kind && here) owner = l;
            }
            if (owner == k) continue;
            const bool named = owner < targets.size();
            if (named && !targets[owner].in_group) {
                members.push_back(owner);
                places.push_back(targets[owner].at);
            } else if (!named && c.likeness > enough_likeness && (!c.degraded || c.doubt > 0)) {
                companions.push_back(c.at);
            } else {
                t.rival = std::max(t.rival, c.likeness);
                t.farthest_rival = std::max(t.farthest_rival, length(c.at - t.at));
                nearest = std::min(nearest, length(c.at - t.at));
            }
        }
        if (t.rival > 0 && t.locator->pitch() == 0)
            t.slips = SlipWatch{nearest, view.targets[k].name == "base"};
        if (members.size() + companions.size() < 2) continue;
        for (const std::size_t m : members) targets[m].in_group = true;
        places.insert(places.end(), companions.begin(), companions.end());
        groups.push_back({members, Constellation{places, members.size(), t.locator->extent()}, {}});
        for (const Point& at : companions) groups.back().companions.push_back(companion_of(k, at, image));
    }
}

// Learns an unnamed look-alike of target k.
std::unique_ptr<Locator> ViewTracker::Impl::companion_of(std::size_t k, Point at,
                                                         const ImageView& image) const try {
    View like = view;
    auto& roi = like.targets[k].roi_px;
    roi[0] += static_cast<int>(std::lround(at.x - targets[k].at.x));
    roi[1] += static_cast<int>(std::lround(at.y - targets[k].at.y));
    auto locator = make_locator(like, k);
    return length(locator->learn(image) - at) < 1 ? std::move(locator) : nullptr;
} catch (const InputError&) {
    return nullptr;
}

// The nearest of several positions; none if a second one is almost as near.
bool ViewTracker::Impl::choose_by_distance(Point expected, Candidate& out) const {
    double nearest = 1e9, next = 1e9;
    for (const Candidate& c : candidates) {
        const double d = length(c.at - expected);
        if (d < nearest) {
            next = nearest;
            nearest = d;
            out = c;
        } else {
            next = std::min(next, d);
        }
    }
    return !candidates.empty() && (candidates.size() == 1 || nearest < 0.4 * next);
}

void ViewTracker::Impl::follow_alone(const ImageView& image, std::size_t k, double frames) {
    Followed& t = targets[k];
    Candidate found;
    const Point expected = t.at + frames * t.velocity;
    if (t.seen) {
        const bool here = t.locator->locate(image, expected, found) ||
                          (length(expected - t.at) > 1 && t.locator->locate(image, t.at, found));
        if (here) {
            report(image, k, found, frames);
            return;
        }
    }
    candidates.clear();
    t.locator->search(image, t.at, Sweep::share, candidates);
    if (t.rival > 0)
        std::erase_if(candidates,
                      [&](const Candidate& c) { return c.likeness < t.rival + better_than_rivals; });
    if (choose_by_distance(expected, found)) {
        report(image, k, found, frames);
    } else {
        lose(k, frames);
    }
}

// Each member at its predicted place, without a search of the whole picture.
bool ViewTracker::Impl::follow_near(const ImageView& image, Group& group, double frames) {
    const std::span<const Point> expected = group.constellation.expected(frames);
    candidates.assign(expected.size(), {});
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (!finite(expected[i])) continue;
        const bool named = i < group.targets.size();
        Locator* const locator = named ? targets[group.targets[i]].locator.get()
                                       : group.companions[i - group.targets.size()].get();
        if (locator == nullptr || !locator->locate(image, expected[i], candidates[i]) ||
            (candidates[i].degraded && candidates[i].doubt == 0) || candidates[i].mixed)
            return false;
    }
    if (expected.empty() || !group.constellation.confirm(candidates, frames)) return false;
    for (std::size_t i = 0; i < group.targets.size(); ++i) {
        group.doubt(candidates[i]);
        report(image, group.targets[i], candidates[i], frames);
    }
    return true;
}

void ViewTracker::Impl::follow_group(const ImageView& image, Group& group, double frames) {
    if (follow_near(image, group, frames)) return;
    candidates.clear();
    const Followed& first = targets[group.targets.front()];
    first.locator->search(image, first.at, Sweep::whole, candidates);
    const auto chosen = group.constellation.assign(candidates, image.width, image.height, frames);
    for (std::size_t i = 0; i < group.targets.size(); ++i) {
        const std::size_t k = group.targets[i];
        Candidate found;
        if (chosen[i] == Constellation::nobody) {
            lose(k, frames);
            continue;
        }
        const Point place = candidates[static_cast<std::size_t>(chosen[i])].at;
        Locator& locator = *targets[k].locator;
        if (locator.locate(image, place, found) && length(found.at - place) < 0.5 * locator.extent()) {
            group.doubt(found);
            report(image, k, found, frames);
        } else {
            lose(k, frames);
        }
    }
}

// Two targets at one object: neither is accepted.
void ViewTracker::Impl::part_claims(double frames) {
    for (std::size_t k = 0; k < targets.size(); ++k) {
        for (std::size_t l = 0; l < k; ++l) {
            const Followed &a = targets[k], &b = targets[l];
            if (a.kind != b.kind || !a.locator->interchangeable() || !a.seen || !b.seen) continue;
            const double apart = 0.5 * std::min(a.locator->extent(), b.locator->extent());
            if (length(a.at - b.at) < apart) {
                lose(k, frames);
                lose(l, frames);
            }
        }
    }
}

// Tracking runs in its camera's thread: OpenCV must not start threads of its own.
ViewTracker::ViewTracker(const View& view) : impl_{std::make_unique<Impl>()} {
    cv::setNumThreads(1);
    impl_->view = view;
}
ViewTracker::~ViewTracker() = default;
ViewTracker::ViewTracker(ViewTracker&&) noexcept = default;
ViewTracker& ViewTracker::operator=(ViewTracker&&) noexcept = default;

std::span<const Fix> ViewTracker::update(const ImageView& image, CameraTick tick) {
    Impl& self = *impl_;
    if (image.pixels == nullptr || image.width < 4 || image.height < 4) {
        throw InputError{"camera " + self.view.camera + ": image of " + std::to_string(image.width) + " x " +
                         std::to_string(image.height) + " px; must be at least 4 x 4"};
    }
    const bool old = self.old_rows.in(image);
    if (!self.started) {
        self.start(image);
    } else {
        if (image.width != self.width || image.height != self.height) {
            throw InputError{"camera " + self.view.camera + ": image changes from " +
                             std::to_string(self.width) + " x " + std::to_string(self.height) + " px to " +
                             std::to_string(image.width) + " x " + std::to_string(image.height)};
        }
        if (old) {  // as if it had not come, for those that follow
            std::ranges::fill(self.fixes, Fix{.state = TrackState::repeated});
            return self.fixes;
        }
        const double frames = static_cast<double>(std::max<std::int64_t>(1, tick.n - self.last_tick));
        for (std::size_t k = 0; k < self.targets.size(); ++k) {
            if (!self.targets[k].in_group) self.follow_alone(image, k, frames);
        }
        for (Group& group : self.groups) self.follow_group(image, group, frames);
        self.part_claims(frames);
    }
    self.last_tick = tick.n;
    return self.fixes;
}

std::vector<std::string> ViewTracker::corrections() const {
    std::vector<std::string> all;
    for (const Followed& t : impl_->targets)
        if (const auto c = t.locator->correction())
            all.push_back(
                fmt::format("{}: {} = {:.4g} is {:.1f} % {}: it measures {:.4g} mm at this scale and is "
                            "followed so; correct {} or "
                            "mm_per_px",
                            t.label, c->key, c->told_mm, 100 * std::abs(c->told_mm / c->measured_mm - 1),
                            c->told_mm > c->measured_mm ? "too large" : "too small", c->measured_mm, c->key));
    return all;
}

std::span<const Fix> ViewTracker::update(std::span<const Sighting> sightings) {
    if (sightings.size() != impl_->view.targets.size())
        throw InputError{"camera " + impl_->view.camera + ": a frame has " +
                         std::to_string(sightings.size()) + " sightings; the view has " +
                         std::to_string(impl_->view.targets.size()) + " targets"};
    impl_->fixes.clear();
    for (const Sighting& s : sightings) {
        const bool seen = std::isfinite(s.x_px) && std::isfinite(s.y_px) && std::isfinite(s.sd_px);
        impl_->fixes.push_back(seen ? Fix{s.x_px, s.y_px, s.sd_px, TrackState::ok} : Fix{});
    }
    return impl_->fixes;
}

}  // namespace shaker::tracking
