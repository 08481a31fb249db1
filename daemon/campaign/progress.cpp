#include "daemon/campaign/progress.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::campaign {

namespace {

[[noreturn]] void refuse(std::size_t number, const std::string& why) {
    throw InputError{fmt::format("entry {}: {}", number, why)};
}

// Follows the entries one by one.
class Follower {
public:
    void operator()(const CampaignChange& e) {
        if ((e.what == CampaignChange::What::begun) != out.plan.empty())
            refuse(number,
                   out.plan.empty() ? "the campaign has not begun" : "the campaign has begun already");
        if (e.what == CampaignChange::What::begun) out.plan = e.plan;
        out.campaign = e;
    }
    void operator()(const PointBegun& e) {
        PointProgress& p = out.points[e.point];
        if (p.ended && p.ended->outcome == Outcome::measured)
            refuse(number, fmt::format("point {} is measured already", e.point));
        p.ended.reset();
        if (e.keeps_passes && p.begun > 0) return;
        ++p.begun;
        p.superseded += static_cast<int>(
            std::ranges::count_if(p.passes, [](const PassEnded& pass) { return pass.measurement > 0; }));
        p.passes.clear();
    }
    void operator()(const PassEnded& e) {
        PointProgress& p = in_progress(e.point);
        if (find(p, e.pass) != p.passes.end())
            refuse(number, fmt::format("pass {} of point {} is counted already", e.pass, e.point));
        if (e.measurement > 0) {
            const auto [known, fresh] = counted_.try_emplace({e.recording, e.measurement}, number);
            if (!fresh)
                refuse(number, fmt::format("measurement {} of {}.nxs is counted already, by entry {}",
                                           e.measurement, e.recording, known->second));
        }
        p.passes.push_back(e);
    }
    void operator()(const PassLost& e) {
        const auto point = out.points.find(e.point);
        const auto pass =
            point == out.points.end() ? std::vector<PassEnded>::iterator{} : find(point->second, e.pass);
        if (point == out.points.end() || pass == point->second.passes.end())
            refuse(number, fmt::format("point {} has no pass {}", e.point, e.pass));
        point->second.passes.erase(pass);
        point->second.ended.reset();
    }
    void operator()(const Returned& e) { static_cast<void>(in_progress(e.point)); }
    void operator()(const PointEnded& e) {
        if (e.outcome == Outcome::left_out && !out.points.contains(e.point)) {
            out.points[e.point].ended = e;  // without having been begun
            return;
        }
        PointProgress& p = in_progress(e.point);
        if (e.outcome == Outcome::measured &&
            std::ranges::none_of(p.passes, [](const PassEnded& pass) { return pass.measurement > 0; }))
            refuse(number, fmt::format("point {} is measured without a measurement", e.point));
        p.ended = e;
    }

    Progress out;
    std::size_t number = 0;

private:
    static std::vector<PassEnded>::iterator find(PointProgress& p, int pass) {
        return std::ranges::find(p.passes, pass, &PassEnded::pass);
    }
    PointProgress& in_progress(int point) {
        const auto p = out.points.find(point);
        if (p == out.points.end() || p->second.ended)
            refuse(number, fmt::format("point {} is not in progress", point));
        return p->second;
    }

    std::map<std::pair<std::string, int>, std::size_t> counted_;  // measurements, with their entries
};

}  // namespace

bool Progress::done(int point) const {
    const auto p = points.find(point);
    return p != points.end() && p->second.ended.has_value();
}

Progress progress_of(std::span<const JournalEntry> entries) {
    Follower follower;
    for (const JournalEntry& entry : entries) {
        ++follower.number;
        std::visit(follower, entry.what);
    }
    return std::move(follower.out);
}

}  // namespace shaker::campaign
