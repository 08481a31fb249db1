#include "daemon/campaign/progress.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "drivers/errors.hpp"

namespace shaker::campaign {

struct Follower::Count {
    Progress& out;
    std::size_t number;

    void remark(const std::string& why) const {
        out.remarks.push_back(fmt::format("entry {}: {}", number, why));
    }
    [[noreturn]] void refuse(const std::string& why) const {
        throw InputError{fmt::format("entry {}: {}", number, why)};
    }
    static bool measured(const PassEnded& pass) { return pass.measurement > 0; }
    static void require_measurement(PointProgress& p) {
        if (p.ended && p.ended->outcome == Outcome::measured && std::ranges::none_of(p.passes, measured))
            p.ended.reset();
    }
    /// The point, if it is in progress; else null, with a remark.
    PointProgress* in_progress(int point) const {
        const auto p = out.points.find(point);
        if (p != out.points.end() && !p->second.ended) return &p->second;
        remark(fmt::format("point {} is not in progress", point));
        return nullptr;
    }

    void operator()(const CampaignChange& e) const {
        if ((e.what == CampaignChange::What::begun) != out.plan.empty())
            refuse(out.plan.empty() ? "the campaign has not begun" : "the campaign has begun already");
        if (e.what == CampaignChange::What::begun) out.plan = e.plan;
        out.campaign = e;
    }
    void operator()(const PointBegun& e) const {
        PointProgress& p = out.points[e.point];
        if (p.ended && p.ended->outcome == Outcome::measured)
            remark(fmt::format("point {} is measured already; it is measured again", e.point));
        p.ended.reset();
        if (e.keeps_passes && p.begun > 0) return;
        ++p.begun;
        p.superseded += static_cast<int>(std::ranges::count_if(p.passes, measured));
        p.passes.clear();
    }
    void operator()(const PassEnded& e) const {
        PointProgress* p = in_progress(e.point);
        if (p == nullptr) return;
        const auto twin = std::ranges::find(p->passes, e.pass, &PassEnded::pass);
        if (twin != p->passes.end()) {
            remark(fmt::format("pass {} of point {} is reported twice", e.pass, e.point));
            if (measured(*twin) && !measured(e)) return;
            p->passes.erase(twin);
        }
        if (measured(e)) forget(e);
        p->passes.push_back(e);
    }
    /// The measurement of `e` counts nowhere else.
    void forget(const PassEnded& e) const {
        for (auto& [id, p] : out.points) {
            const auto same = [&](const PassEnded& o) {
                return o.measurement == e.measurement && o.recording == e.recording;
            };
            if (std::erase_if(p.passes, same) == 0) continue;
            remark(fmt::format("measurement {} of {}.nxs was counted for point {} already", e.measurement,
                               e.recording, id));
            require_measurement(p);
        }
    }
    void operator()(const PassLost& e) const {
        const auto point = out.points.find(e.point);
        const auto is = [&](const PassEnded& pass) { return pass.pass == e.pass; };
        if (point == out.points.end() || std::erase_if(point->second.passes, is) == 0)
            return remark(fmt::format("point {} has no pass {}", e.point, e.pass));
        point->second.ended.reset();
    }
    void operator()(const Returned& e) const { static_cast<void>(in_progress(e.point)); }
    void operator()(const PointEnded& e) const {
        const bool untouched = !out.points.contains(e.point);
        if (!(untouched && e.outcome == Outcome::left_out)) static_cast<void>(in_progress(e.point));
        PointProgress& p = out.points[e.point];
        p.ended = e;
        require_measurement(p);
        if (!p.ended) remark(fmt::format("point {} is measured without a measurement", e.point));
    }
};

void Follower::operator()(const JournalEntry& entry) {
    ++number_;
    std::visit(Count{out_, number_}, entry.what);
}

bool Progress::done(int point) const {
    const auto p = points.find(point);
    return p != points.end() && p->second.ended.has_value();
}

Progress progress_of(std::span<const JournalEntry> entries) {
    Follower follower;
    for (const JournalEntry& entry : entries) follower(entry);
    return follower.progress();
}

}  // namespace shaker::campaign
