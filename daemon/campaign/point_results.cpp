#include "daemon/campaign/point_results.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/combined_passes.hpp"
#include "daemon/campaign/common_errors.hpp"
#include "daemon/campaign/run_points.hpp"
#include "daemon/recording/replay.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/recording/time_text.hpp"
#include "drivers/with_error.hpp"

namespace shaker::campaign {

namespace {

using calibration::Estimate;
using recording::MeasuredResult;
using reduction::Reduction;

std::vector<MeasuredResult> computed_again(const recorded::RecordingReader& file, std::string& how) {
    const std::string why = recording::why_not_followed_again(file);
    how = why.empty() ? "computed again from pictures or positions of the cameras"
                      : "computed again from the stored tracks: " + why;
    std::vector<std::string> notes;
    const auto streams = recording::replayed_streams(file, file.header(), why.empty(), notes);
    std::vector<MeasuredResult> results;
    for (const recording::FinishedMeasurement& m : recording::read_finished(file))
        results.push_back(recording::reduced(m, streams, file.header().frequency_hz));
    return results;
}

// The results of one recording, or the reason why it has none.
struct Recorded {
    std::vector<MeasuredResult> results;
    std::string missing;
    double gravity = NAN;   // m/s^2; NaN: without a recording
    bool smoothed = false;  // v of the cycles, across kinks
};

Recorded results_of(const std::filesystem::path& folder, const std::string& name, Source source,
                    std::vector<std::string>& remarks) {
    const std::filesystem::path file = folder / (name + ".nxs"), part = folder / (name + ".nxs.part");
    if (!std::filesystem::exists(file))
        return {{},
                std::filesystem::exists(part)
                    ? fmt::format("{} is not complete; \"shakerd recover {}\" completes it",
                                  part.filename().string(), part.string())
                    : fmt::format("{} does not exist", file.string())};
    const recorded::RecordingReader reader{file};
    recording::require_known_schema(reader);
    const double gravity = gravity_in(reader);
    if (source == Source::stored)
        return {recording::read_results(reader),
                {},
                gravity,
                reader.header().schema < recording::unsmoothed_since};
    std::string how;
    Recorded recorded{computed_again(reader, how), {}, gravity};
    remarks.push_back(fmt::format("{}: {}", file.filename().string(), how));
    return recorded;
}

struct FoundPass {
    const PassEnded* ended;
    const MeasuredResult* result = nullptr;  // null: the recording does not have it
    std::string missing{};                   // reason
};

double periods_of(const recording::FinishedMeasurement& m) {
    return std::round((m.part.to_s - m.part.from_s) * m.asked.frequency);
}

template <class Get>
auto of_each(const std::vector<const Reduction*>& reductions, const Get& get) {
    std::vector<std::invoke_result_t<Get, const Reduction&>> values;
    for (const Reduction* r : reductions) values.push_back(get(*r));
    return values;
}

// Fills the rows of one point from the passes that have results.
class PointRows {
public:
    PointRows(PointsTable& table, PointRow row) : table_{table}, row_{std::move(row)} {}

    void add(std::vector<FoundPass>& passes) {
        std::erase_if(passes, [&](const FoundPass& p) {
            add_pass(p);
            return p.result == nullptr || !p.result->reduction;
        });
        if (row_.outcome == outcome_words[0] && passes.empty()) row_.outcome = outcome_words[1];
        if (row_.outcome != outcome_words[0]) passes.clear();
        if (!passes.empty()) combine(passes);
        add_harmonics();
        add_cycle();
        table_.points.push_back(std::move(row_));
    }

private:
    void add_pass(const FoundPass& p) {
        PointPass out{.point = row_.point,
                      .pass = p.ended->pass,
                      .recording = p.ended->recording,
                      .measurement = p.ended->measurement,
                      .from_s = p.ended->from_s,
                      .to_s = p.ended->to_s,
                      .x_from_m = p.ended->x_from_m,
                      .x_to_m = p.ended->x_to_m,
                      .true_v_D = p.ended->true_v_D,
                      .how = std::string{PassEnded::words[static_cast<std::size_t>(p.ended->how)]},
                      .reason = p.missing.empty() ? p.ended->reason : p.missing};
        if (p.result != nullptr && p.result->reduction) {
            out.from_s = p.result->measurement.part.from_s;
            out.to_s = p.result->measurement.part.to_s;
            out.periods = periods_of(p.result->measurement);
            out.v_D = p.result->reduction->v_D;
            for (const reduction::StickInterval& s : p.result->reduction->stick)
                table_.stick.push_back({row_.point, out.pass, s});
        } else if (row_.reason.empty()) {
            row_.reason = out.reason;
        }
        table_.passes.push_back(std::move(out));
    }

    void combine(const std::vector<FoundPass>& passes) {
        std::vector<reduction::PassDrift> drifts;
        row_.true_v_D = row_.travel_m = 0;
        for (const FoundPass& p : passes) {
            reductions_.push_back(&*p.result->reduction);
            if (const auto doubts = doubts_of(*reductions_.back()); row_.doubt.empty() && !doubts.empty())
                row_.doubt = doubts.front();
            drifts.push_back({reductions_.back()->v_D, static_cast<int>(periods_of(p.result->measurement))});
            row_.periods += periods_of(p.result->measurement);
            row_.frames += reductions_.back()->frames;
            row_.frames_lost += reductions_.back()->frames_lost;
            row_.travel_m += p.ended->x_to_m - p.ended->x_from_m;
        }
        const reduction::CombinedDrift drift = reduction::combined(drifts);
        weights_ = drift.weights;
        row_.v_D = drift.v_D;
        row_.chi2 = drift.chi2;
        for (std::size_t i = 0; i < passes.size(); ++i)
            row_.true_v_D += weights_[i] * passes[i].ended->true_v_D;
        row_.passes = static_cast<int>(passes.size());
        row_.recording = passes.front().ended->recording;
        row_.measurement = passes.front().ended->measurement;
        row_.time = passes.back().result->measurement.time;
        using To = Estimate PointRow::*;
        using From = Estimate Reduction::*;
        for (const auto& [to, from] : {std::pair<To, From>{&PointRow::D, &Reduction::D},
                                       {&PointRow::frequency, &Reduction::frequency},
                                       {&PointRow::gamma, &Reduction::gamma},
                                       {&PointRow::rho, &Reduction::rho},
                                       {&PointRow::v_rms, &Reduction::v_rms},
                                       {&PointRow::efficiency, &Reduction::efficiency}})
            row_.*to = reduction::weighted(
                of_each(reductions_, [from](const Reduction& r) { return r.*from; }), weights_);
        for (const Reduction* r : reductions_)
            row_.phi_systematic = std::fmax(row_.phi_systematic, r->systematic.phi);
        // The errors of the sensor's offset and of a corner in the settings are the same in all passes: they
        // add.
        row_.tilt = row_.corner = {0, 0};
        for (std::size_t i = 0; i < reductions_.size(); ++i)
            for (const auto& [to, from] : {std::pair{&row_.tilt, &reductions_[i]->tilt.angle},
                                           {&row_.corner, &reductions_[i]->corner.hz}}) {
                to->value += weights_[i] * from->value;
                to->sigma += weights_[i] * from->sigma;
            }
        row_.phi = reduction::weighted_angle(of_each(reductions_, [](const Reduction& r) { return r.phi; }),
                                             weights_);
    }

    void add_harmonics() {
        const Harmonics<Acceleration> asked = harmonics(row_.asked);
        for (int q = 1; q <= max_harmonics; ++q)
            table_.harmonics.push_back({row_.point, weighted(q, reductions_, weights_), std::abs(asked.at(q)),
                                        std::arg(asked.at(q))});
    }

    void add_cycle() {
        const reduction::Cycle cycle = weighted(
            of_each(reductions_, [](const Reduction& r) { return resampled(r.cycle, r.D.value); }), weights_);
        for (int k = 0; k < cycle_phases; ++k) {
            PointPhase& p = table_.cycle.emplace_back(
                PointPhase{.point = row_.point, .phase = static_cast<double>(k) / cycle_phases});
            const auto i = static_cast<std::size_t>(k);
            if (i < cycle.phase.size())
                p = {row_.point,     p.phase,           cycle.x_m[i],       cycle.x_sd_m[i],
                     cycle.v_mps[i], cycle.v_sd_mps[i], cycle.v_base_mps[i]};
        }
    }

    PointsTable& table_;
    PointRow row_;
    std::vector<const Reduction*> reductions_;
    std::vector<double> weights_;
};

FoundPass found(const PassEnded& ended, const std::map<std::string, Recorded>& recordings) {
    FoundPass pass{.ended = &ended};
    if (ended.measurement == 0) return pass;
    const Recorded& recorded = recordings.at(ended.recording);
    const auto result = std::ranges::find(recorded.results, ended.measurement,
                                          [](const MeasuredResult& r) { return r.measurement.number; });
    if (result != recorded.results.end())
        pass.result = &*result;
    else
        pass.missing = recorded.missing;
    if (pass.result != nullptr && !pass.result->reduction)
        pass.missing = result->not_reduced;
    else if (pass.result == nullptr && pass.missing.empty())
        pass.missing = "the recording does not have it";
    if (!pass.missing.empty())
        pass.missing =
            fmt::format("measurement {} of {}.nxs: {}", ended.measurement, ended.recording, pass.missing);
    return pass;
}

std::map<std::string, Recorded> recordings_of(const std::filesystem::path& folder, const Progress& progress,
                                              Source source, std::vector<std::string>& remarks) {
    std::map<std::string, Recorded> recordings;
    for (const auto& [number, point] : progress.points)
        for (const PassEnded& pass : point.passes)
            if (pass.measurement > 0 && !recordings.contains(pass.recording))
                recordings[pass.recording] = results_of(folder, pass.recording, source, remarks);
    return recordings;
}

// The passes that count show the walker.
void state_errors_of(std::map<std::string, Recorded>& recordings, const Progress& progress) {
    std::vector<MeasuredResult*> measured;
    for (auto& [name, recording] : recordings)
        for (MeasuredResult& result : recording.results) {
            const auto is = [&, of = &name](const PassEnded& pass) {
                return pass.recording == *of && pass.measurement == result.measurement.number;
            };
            if (std::ranges::any_of(progress.points,
                                    [&](const auto& p) { return std::ranges::any_of(p.second.passes, is); }))
                measured.push_back(&result);
        }
    state_common_errors(measured);
}

law::Point with_numbers(const PointRow& row, int campaign) {
    law::Point p;
    p.number = row.point;
    p.campaign = campaign;
    p.partner = row.partner;
    p.series = row.series;
    p.asked = row.asked;
    p.frequency = row.frequency.value;
    p.gamma = row.gamma;
    p.rho = row.rho;
    p.phi = row.phi;
    p.v_D = row.v_D;
    p.true_v_D = row.true_v_D;
    p.tilt = row.tilt;
    if (std::isfinite(row.phi_systematic)) p.turn_told = row.phi_systematic;
    p.time_s = recording::seconds_of(row.time);
    p.doubt = row.doubt;
    p.periods = static_cast<int>(std::lround(row.periods));
    if (row.periods > 0) p.phases_per_period = row.frames / row.periods / law::most_views;
    return p;
}

}  // namespace

std::vector<PointRow> asked_rows(std::span<const Point> points) {
    std::vector<PointRow> rows;
    for (const Point& p : points)
        rows.push_back({.point = p.id,
                        .series = p.series,
                        .repeat = p.repeat,
                        .partner = p.partner,
                        .asked = p.asked.drive});
    return rows;
}

void name_other_corners(std::vector<PointRow>& rows) {
    constexpr std::size_t fewest = 3;  // others
    constexpr double improbable = 5;   // standard errors
    // Largest relative difference of frequencies: a low-pass that is not in the settings moves the corner
    // with the frequency.
    constexpr double alike = 0.1;
    constexpr double of_median = 1.25;  // its error over that of a mean
    for (PointRow& row : rows) {
        std::vector<Estimate> others;
        for (const PointRow& other : rows)
            if (&other != &row && other.corner.sigma > 0 &&
                std::abs(other.asked.frequency / row.asked.frequency - 1) < alike)
                others.push_back(other.corner);
        if (others.size() < fewest || !(row.corner.sigma > 0) || !row.doubt.empty()) continue;
        const auto middle = others.begin() + static_cast<std::ptrdiff_t>(others.size() / 2);
        std::ranges::nth_element(others, middle, {}, &Estimate::sigma);
        const double error = of_median * middle->sigma / std::sqrt(static_cast<double>(others.size()));
        std::ranges::nth_element(others, middle, {}, &Estimate::value);
        if (std::abs(row.corner.value - middle->value) > improbable * std::hypot(row.corner.sigma, error))
            row.doubt = fmt::format(
                "the accelerometer's lower corner is {} Hz here, {} Hz at the other points: was the sensor "
                "or its input changed, or is a low-pass not stated?",
                with_error(row.corner.value, row.corner.sigma), with_error(middle->value, error));
    }
}

PointResults point_results(const std::filesystem::path& folder, std::span<const PointRow> asked,
                           const Progress& progress, Source source) {
    PointResults out;
    for (const std::string& remark : progress.remarks)
        out.remarks.push_back(fmt::format("{}, {}", journal_name, remark));
    std::map<std::string, Recorded> recordings = recordings_of(folder, progress, source, out.remarks);
    state_errors_of(recordings, progress);
    for (const auto& [name, recording] : recordings) {
        if (std::isfinite(recording.gravity)) out.table.gravity = recording.gravity;
        out.table.smoothed |= recording.smoothed;
    }
    for (PointRow row : asked) {
        std::vector<FoundPass> passes;
        if (const auto point = progress.points.find(row.point); point != progress.points.end()) {
            row.begun = point->second.begun;
            row.outcome = "in progress";
            if (const auto& ended = point->second.ended) {
                row.outcome = outcome_words[static_cast<std::size_t>(ended->outcome)];
                row.reason = ended->reason;
            }
            for (const PassEnded& pass : point->second.passes) {
                passes.push_back(found(pass, recordings));
                if (passes.back().missing.empty()) continue;
                out.lost.push_back({row.point, pass.pass, passes.back().missing});
                out.remarks.push_back(
                    fmt::format("point {}, pass {}: {}", row.point, pass.pass, passes.back().missing));
            }
        }
        PointRows{out.table, std::move(row)}.add(passes);
    }
    name_other_corners(out.table.points);
    return out;
}

std::vector<law::Point> law_points(const PointsTable& table, int campaign) {
    std::map<int, law::Point> found;
    for (const PointRow& row : table.points) {
        const bool measured = row.outcome == "measured" && std::isfinite(row.v_D.value) &&
                              row.v_D.sigma > 0 && std::isfinite(row.frequency.value) &&
                              row.frequency.value > 0;
        if (measured) found.emplace(row.point, with_numbers(row, campaign));
    }
    const auto point = [&](int number) {
        const auto at = found.find(number);
        return at == found.end() ? nullptr : &at->second;
    };
    for (const PointHarmonic& h : table.harmonics) {
        law::Point* p = point(h.point);
        if (p == nullptr || !p->take(h.measured)) continue;
        if (h.measured.q > 2 && h.measured.q <= most_driven)
            p->asked.overtones[static_cast<std::size_t>(h.measured.q - 3)] =
                std::polar(h.asked / p->asked.gamma, h.asked_phase);
    }
    for (const PointPhase& c : table.cycle) {
        law::Point* p = point(c.point);
        if (p == nullptr || !std::isfinite(c.v_mps)) continue;
        if (table.smoothed) p->kink_frames = law::smoothed_frames;
        p->cycle.phase.push_back(c.phase);
        p->cycle.x_m.push_back(c.x_m);
        p->cycle.x_sd_m.push_back(c.x_sd_m);
        p->cycle.v_mps.push_back(c.v_mps);
        p->cycle.v_sd_mps.push_back(c.v_sd_mps);
        p->cycle.v_base_mps.push_back(c.v_base_mps);
    }
    for (const PointStick& s : table.stick)
        if (law::Point* p = point(s.point)) p->stick.push_back(s.interval);
    std::map<int, std::vector<double>> places;
    for (const PointPass& pass : table.passes)
        if (std::isfinite(pass.x_from_m) && std::isfinite(pass.x_to_m))
            places[pass.point].push_back(0.5 * (pass.x_from_m + pass.x_to_m));
    for (const auto& [number, x] : places)
        if (law::Point* p = point(number))
            p->place = std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
    std::vector<law::Point> out;
    for (auto& [number, p] : found)
        if (p.base.order() > 0) out.push_back(std::move(p));
    return out;
}

}  // namespace shaker::campaign
