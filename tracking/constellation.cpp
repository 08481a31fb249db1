#include "tracking/constellation.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace shaker::tracking {
namespace {

// Costs are halves of chi squared: 10 is a likelihood ratio of e^10. A hidden member or a stray candidate
// alone is not decisive; both together are. A member that left the picture costs nothing.
constexpr double looseness_px = 0.75;
constexpr double cost_of_missing = 4.5, cost_of_left_over = 6, cost_of_haste = 6, enough_margin = 10;
// A candidate left over whose place in frame 0 was in the picture, and empty.
constexpr double cost_of_stranger = 12;
constexpr double farthest_step = 0.8;  // of the distance to the neighbour, per frame
// In a gap a member may move so much more than the fastest step makes of it, or than the range of all places.
// After a gap longer than this share of the time watched it may have moved farther: the names are doubted.
constexpr double gap_margin = 1.5, longest_gap = 0.5;
constexpr double longest_companion_absence = 30;
constexpr double most_misfit = 0.5 * enough_margin;

}  // namespace

Constellation::Constellation(std::span<const Point> places, std::size_t targets, double radius)
    : targets_{targets}, radius_{radius}, chosen_(targets, nobody) {
    for (const Point& p : places) {
        Member m{.at = p, .velocity = {}, .neighbour = 1e9, .began = p};
        for (const Point& other : places) {
            if (&p != &other) m.neighbour = std::min(m.neighbour, length(p - other));
        }
        members_.push_back(m);
    }
}

double Constellation::doubt_px() const noexcept {
    return doubts_ ? 0.5 * std::ranges::min(members_, {}, &Member::neighbour).neighbour : 0;
}

// Largest distance from a member's place, px.
double Constellation::off_place(const Member& m) noexcept { return std::max(2.5, 0.06 * m.neighbour); }

// Half the sum of squares after subtracting a common shift and, for three or more members, a common rotation
// and stretch (a swing towards the camera magnifies).
double Constellation::misfit(const std::vector<int>& chosen, std::span<const Candidate> candidates,
                             double frames) const {
    using Complex = std::complex<double>;
    Complex middle{}, shift{};
    double n = 0;
    const auto each = [&](auto f) {
        for (std::size_t k = 0; k < members_.size(); ++k) {
            if (chosen[k] == nobody) continue;
            const Point expected = members_[k].at + frames * members_[k].velocity;
            const Point off = candidates[static_cast<std::size_t>(chosen[k])].at - expected;
            f(Complex{expected.x, expected.y}, Complex{off.x, off.y});
        }
    };
    each([&](Complex p, Complex e) { middle += p, shift += e, n += 1; });
    if (n < 2) return 0;
    middle /= n;
    shift /= n;
    Complex turn{};
    double arm = 0;
    each([&](Complex p, Complex e) {
        turn += std::conj(p - middle) * (e - shift);
        arm += std::norm(p - middle);
    });
    const Complex rotation = n > 2 && arm > 0 ? turn / arm : Complex{};
    double sum = 0;
    each([&](Complex p, Complex e) { sum += std::norm(e - shift - rotation * (p - middle)); });
    return 0.5 * sum / (looseness_px * looseness_px);
}

bool Constellation::too_far(const Member& m, Point to, double frames) const {
    const double gap = frames + m.unseen;
    return gap >= 2 &&
           length(to - m.at) > off_place(m) + gap_margin * std::min(fastest_ * gap, 2 * farthest_);
}

Constellation::Hypothesis Constellation::try_displacement(Point displacement,
                                                          std::span<const Candidate> candidates, int width,
                                                          int height, double frames) const {
    Hypothesis h;
    h.chosen.assign(members_.size(), nobody);
    h.moved = displacement;
    std::vector<int> owner(candidates.size(), nobody);
    std::vector<double> distance(candidates.size(), 0.0);
    for (std::size_t k = 0; k < members_.size(); ++k) {
        const Member& m = members_[k];
        const Point expected = m.at + frames * m.velocity + displacement;
        double nearest = off_place(m);
        int best = nobody;
        for (std::size_t j = 0; j < candidates.size(); ++j) {
            const double off = length(candidates[j].at - expected);
            const double step = length(candidates[j].at - m.at);
            if (off < nearest && step < farthest_step * m.neighbour * (frames + m.unseen)) {
                nearest = off;
                best = static_cast<int>(j);
            }
        }
        if (best != nobody) {
            const auto j = static_cast<std::size_t>(best);
            if (owner[j] == nobody || nearest < distance[j]) {
                if (owner[j] != nobody) h.chosen[static_cast<std::size_t>(owner[j])] = nobody;
                owner[j] = static_cast<int>(k);
                distance[j] = nearest;
                h.chosen[k] = best;
            }
        }
    }
    weigh(h, candidates, owner, width, height, frames);
    return h;
}

void Constellation::weigh(Hypothesis& h, std::span<const Candidate> candidates, std::span<const int> owner,
                          int width, int height, double frames) const {
    const auto in_view = [&](Point p) {
        return p.x > radius_ && p.y > radius_ && p.x < width - 1 - radius_ && p.y < height - 1 - radius_;
    };
    Point since_start;
    for (std::size_t k = 0; k < members_.size(); ++k) {
        const Member& m = members_[k];
        if (h.chosen[k] != nobody) {
            const Point at = candidates[static_cast<std::size_t>(h.chosen[k])].at;
            if (too_far(m, at, frames)) h.haste = cost_of_haste;
            since_start = at - m.began;
            ++h.named;
            ++h.expected;
        } else if (!m.gone && in_view(m.at + frames * m.velocity + h.moved)) {
            h.cost += cost_of_missing;
            ++h.expected;
        }
    }
    for (std::size_t j = 0; j < candidates.size(); ++j) {
        if (owner[j] == nobody)
            h.cost += in_view(candidates[j].at - since_start) ? cost_of_stranger : cost_of_left_over;
    }
    h.cost += misfit(h.chosen, candidates, frames) + h.haste;
}

bool Constellation::contradict(const Hypothesis& a, const Hypothesis& b) const {
    for (std::size_t k = 0; k < members_.size(); ++k) {
        if (a.chosen[k] != nobody && b.chosen[k] != nobody && a.chosen[k] != b.chosen[k]) return true;
        // The same candidate assigned to different members is a contradiction too.
        for (std::size_t l = 0; l < members_.size(); ++l) {
            if (l != k && a.chosen[k] != nobody && a.chosen[k] == b.chosen[l]) return true;
        }
    }
    return false;
}

// A few of many members count only if they are where they were expected.
bool Constellation::convincing(const Hypothesis& best) const {
    if (best.named == 0) return false;
    double nearest = 1e9;
    for (const Member& m : members_) nearest = std::min(nearest, m.neighbour);
    return 2 * best.named >= best.expected || length(best.moved) < 0.1 * nearest;
}

void Constellation::follow(const Hypothesis& best, std::span<const Candidate> candidates, double frames) {
    Point moved, velocity;
    watched_ += frames;
    double fewest = 1e9, measured = 0;  // pictures unseen; members that were seen so lately
    for (std::size_t k = 0; k < members_.size(); ++k)
        if (best.chosen[k] != nobody) fewest = std::min(fewest, members_[k].unseen);
    for (std::size_t k = 0; k < members_.size(); ++k) {
        if (best.chosen[k] == nobody) continue;
        Member& m = members_[k];
        const Point step = candidates[static_cast<std::size_t>(best.chosen[k])].at - m.at;
        if (frames + m.unseen < 2) fastest_ = std::max(fastest_, length(step));
        farthest_ = std::max(farthest_, length(m.at + step - m.began));
        m.gone = false;
        m.at = m.at + step;
        moved = moved + (1.0 / best.named) * step;
        if (m.unseen > fewest) continue;
        m.velocity = (1 / (frames + m.unseen)) * step;
        velocity = velocity + m.velocity;
        measured += 1;
    }
    velocity = (1 / measured) * velocity;
    for (std::size_t k = 0; k < members_.size(); ++k) {
        Member& m = members_[k];
        if (best.chosen[k] != nobody) {  // one that was longer unseen was moved along with the others
            if (m.unseen > fewest) m.velocity = velocity;
            m.unseen = 0;
            continue;
        }
        m.at = m.at + moved;
        m.velocity = velocity;
        m.unseen += frames;
        if (k >= targets_ && m.unseen > longest_companion_absence) m.gone = true;
    }
}

void Constellation::miss(double frames) {
    for (Member& m : members_) {
        m.velocity = {};
        m.unseen += frames;
    }
}

std::span<const Point> Constellation::expected(double frames) {
    expected_.clear();
    for (const Member& m : members_) {
        if (!m.gone && m.unseen > 0) return {};
        expected_.push_back(m.gone ? Point{NAN, NAN} : m.at + frames * m.velocity);
    }
    return expected_;
}

bool Constellation::confirm(std::span<const Candidate> found, double frames) {
    Hypothesis h;
    h.chosen.assign(members_.size(), nobody);
    for (std::size_t k = 0; k < members_.size(); ++k) {
        const Member& m = members_[k];
        if (m.gone) continue;
        const bool at_its_place = length(found[k].at - expected_[k]) < off_place(m) &&
                                  length(found[k].at - m.at) < farthest_step * m.neighbour * frames;
        if (!at_its_place) return false;
        h.chosen[k] = static_cast<int>(k);
        ++h.named;
    }
    if (misfit(h.chosen, found, frames) > most_misfit) return false;
    follow(h, found, frames);
    return true;
}

std::span<const int> Constellation::assign(std::span<const Candidate> candidates, int width, int height,
                                           double frames) {
    std::vector<Hypothesis> tried;
    for (const Member& m : members_) {
        if (m.gone) continue;
        for (const Candidate& c : candidates) {
            if (length(c.at - m.at) > farthest_step * m.neighbour * (frames + m.unseen)) continue;
            Hypothesis h =
                try_displacement(c.at - m.at - frames * m.velocity, candidates, width, height, frames);
            const auto same = [&](const Hypothesis& o) { return o.chosen == h.chosen; };
            if (std::none_of(tried.begin(), tried.end(), same)) tried.push_back(std::move(h));
        }
    }
    std::fill(chosen_.begin(), chosen_.end(), nobody);
    const auto cheaper = [](const Hypothesis& a, const Hypothesis& b) { return a.cost < b.cost; };
    const auto best = std::min_element(tried.begin(), tried.end(), cheaper);
    const auto rivals = [&](double without) {
        return std::ranges::any_of(tried, [&](const Hypothesis& o) {
            const double cost = o.cost - without * o.haste;
            return &o != &*best && cost < best->cost + enough_margin && contradict(*best, o);
        });
    };
    if (best == tried.end() || !convincing(*best) || rivals(0)) {
        miss(frames);
        return chosen_;
    }
    double gap = frames;
    for (const Member& m : members_) gap = std::max(gap, frames + (m.gone ? 0 : m.unseen));
    doubts_ = doubts_ || (gap > longest_gap * watched_ && rivals(1));
    std::copy_n(best->chosen.begin(), targets_, chosen_.begin());
    follow(*best, candidates, frames);
    return chosen_;
}

}  // namespace shaker::tracking
