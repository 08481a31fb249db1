#include "daemon/recorder.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "drivers/errors.hpp"

namespace shaker {

namespace {

void add(std::vector<RecordedNumber>& list, const std::string& name, const Estimate& e,
         const std::string& units) {
    list.push_back({"results/" + name, e.value, units});
    list.push_back({"results/" + name + "_errors", e.sigma, units});
}

Column column(std::string name, std::string units, const auto& rows, auto&& value) {
    Column c{std::move(name), std::move(units), {}};
    c.values.reserve(rows.size());
    for (const auto& row : rows) c.values.push_back(static_cast<double>(value(row)));
    return c;
}

bool same(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
           (std::isnan(a) && std::isnan(b));
}

const std::vector<double>& values_of(const std::vector<Column>& columns, const std::string& name,
                                     const std::string& path) {
    const auto it = std::ranges::find(columns, name, &Column::name);
    if (it == columns.end())
        throw InputError{"recording: table \"" + path + "\" has no column \"" + name + "\""};
    return it->values;
}

std::string track_path(const TargetTrack& t) { return "tracks/" + t.camera + "/" + t.target.name; }

}  // namespace

std::vector<RecordedNumber> numbers_of(const Reduction& r) {
    std::vector<RecordedNumber> list;
    add(list, "v_D", r.v_D, "m/s");
    add(list, "D", r.D, "m");
    add(list, "frequency", r.frequency, "Hz");
    add(list, "gamma", r.gamma, "m/s^2");
    add(list, "rho", r.rho, "1");
    add(list, "phi", r.phi, "rad");
    add(list, "v_rms", r.v_rms, "m/s");
    add(list, "efficiency", r.efficiency, "1");
    add(list, "accelerometer_late", r.accelerometer_late_s, "s");
    add(list, "accelerometer_ppm", r.accelerometer_ppm, "1e-6");
    list.push_back({"results/fit_residual", r.fit_residual_x_m.value, "m"});
    list.push_back({"results/t0", r.t0_s, "s"});
    for (std::size_t k = 0; k < 3; ++k)
        list.push_back({fmt::format("results/shaker_axis_{}", "xyz"[k]), r.shaker_axis[k], "1"});
    list.push_back({"results/frames", static_cast<double>(r.frames), "1"});
    list.push_back({"results/frames_lost", static_cast<double>(r.frames_lost), "1"});
    return list;
}

RecordedTable transverse_table(const std::string& path, const std::vector<double>& frequency_hz,
                               const std::vector<Transverse>& across) {
    std::vector<Column> columns{
        {"frequency", "Hz", frequency_hz},
        column("amplitude", "m/s^2", across, [](const Transverse& t) { return t.amplitude.value; }),
        column("amplitude_errors", "m/s^2", across, [](const Transverse& t) { return t.amplitude.sigma; }),
        column("share", "1", across, [](const Transverse& t) { return t.share.value; }),
        column("share_errors", "1", across, [](const Transverse& t) { return t.share.sigma; }),
        column("in_phase", "1", across, [](const Transverse& t) { return t.in_phase; }),
        column("quadrature", "1", across, [](const Transverse& t) { return t.quadrature; })};
    for (std::size_t k = 0; k < 3; ++k)
        columns.push_back(column(fmt::format("direction_{}", "xyz"[k]), "1", across,
                                 [k](const Transverse& t) { return t.direction[k]; }));
    return {path,
            columns,
            "NXdata",
            {{"signal", "share"},
             {"axes", "frequency"},
             {"title", "motion across the shaker's axis over that along it"}}};
}

std::vector<RecordedTable> tables_of(const Reduction& r) {
    std::vector<RecordedTable> tables;
    tables.push_back(
        {"harmonics",
         {column("q", "1", r.harmonics, [](const auto& h) { return h.q; }),
          column("amplitude", "m/s^2", r.harmonics, [](const auto& h) { return h.amplitude.value; }),
          column("amplitude_errors", "m/s^2", r.harmonics, [](const auto& h) { return h.amplitude.sigma; }),
          column("phase", "rad", r.harmonics, [](const auto& h) { return h.phase.value; }),
          column("phase_errors", "rad", r.harmonics, [](const auto& h) { return h.phase.sigma; })},
         "NXcollection",
         {}});
    std::vector<double> frequency;
    std::vector<Transverse> across;
    for (const MeasuredHarmonic& h : r.harmonics) {
        frequency.push_back(h.q * r.frequency.value);
        across.push_back(h.across);
    }
    tables.push_back(transverse_table("transverse", frequency, across));
    tables.push_back(
        {"periods",
         {column("k", "1", r.periods, [](const auto& p) { return p.k; }),
          column("t", "s", r.periods, [](const auto& p) { return p.t_s; }),
          column("frames", "1", r.periods, [](const auto& p) { return p.frames; }),
          column("D", "m", r.periods, [](const auto& p) { return p.drift.value; }),
          column("D_errors", "m", r.periods, [](const auto& p) { return p.drift.sigma; }),
          column("gamma", "m/s^2", r.periods, [](const auto& p) { return p.gamma.value; }),
          column("gamma_errors", "m/s^2", r.periods, [](const auto& p) { return p.gamma.sigma; }),
          column("phi", "rad", r.periods, [](const auto& p) { return p.phi.value; }),
          column("phi_errors", "rad", r.periods, [](const auto& p) { return p.phi.sigma; })},
         "NXdata",
         {{"signal", "D"}, {"axes", "t"}}});
    const Cycle& c = r.cycle;
    tables.push_back({"cycle",
                      {{"phase", "1", c.phase},
                       {"x", "m", c.x_m},
                       {"x_errors", "m", c.x_sd_m},
                       {"v", "m/s", c.v_mps},
                       {"v_errors", "m/s", c.v_sd_mps},
                       {"v_base", "m/s", c.v_base_mps}},
                      "NXdata",
                      {{"signal", "v"}, {"axes", "phase"}, {"title", "walker velocity over one period"}}});
    tables.push_back({"stick",
                      {column("from", "1", r.stick, [](const auto& s) { return s.from; }),
                       column("to", "1", r.stick, [](const auto& s) { return s.to; }),
                       column("errors", "1", r.stick, [](const auto& s) { return s.sd; })},
                      "NXcollection",
                      {}});
    return tables;
}

std::vector<double> row_of(const Track& k) {
    return {static_cast<double>(k.tick.n),
            seconds(k.time),
            k.fix.x_px,
            k.fix.y_px,
            k.fix.sd_px,
            k.x_m,
            k.sd_m,
            static_cast<double>(static_cast<int>(k.fix.state))};
}

RecordedTable track_table(const TargetTrack& t) {
    RecordedTable table{track_path(t),
                        {{"frame", "1", {}},
                         {"t", "s", {}},
                         {"x_px", "px", {}},
                         {"y_px", "px", {}},
                         {"sd_px", "px", {}},
                         {"x", "m", {}},
                         {"x_errors", "m", {}},
                         {"state", "1", {}}},
                        "NXdata",
                        {{"signal", "x"}, {"axes", "t"}}};
    for (Column& c : table.columns) c.values.reserve(t.tracks.size());
    for (const Track& k : t.tracks) {
        const std::vector<double> row = row_of(k);
        for (std::size_t i = 0; i < row.size(); ++i) table.columns[i].values.push_back(row[i]);
    }
    return table;
}

std::vector<RecordedTable> tables_of(const Take& take) {
    std::vector<RecordedTable> tables;
    for (const TargetTrack& t : take.tracks) tables.push_back(track_table(t));
    return tables;
}

void write_times(SessionWriter& file, const Take& take) {
    for (const TargetTrack& t : take.tracks) {
        std::vector<double> times;
        times.reserve(t.tracks.size());
        for (const Track& k : t.tracks) times.push_back(seconds(k.time));
        file.replace(track_path(t) + "/t", times);
    }
}

RecordedTable clock_table(const Take& take) {
    RecordedTable table{"clocks",
                        {{"stream", "1", {}},
                         {"ppm", "1e-6", {}},
                         {"ppm_errors", "1e-6", {}},
                         {"delay", "s", {}},
                         {"stamps", "1", {}}}};
    const auto row = [&](double stream, const auto& clock, std::size_t stamps) {
        const std::array<double, 5> values{stream, clock.ppm(), clock.ppm_sigma(), clock.residual().count(),
                                           static_cast<double>(stamps)};
        for (std::size_t i = 0; i < values.size(); ++i) table.columns[i].values.push_back(values[i]);
    };
    if (!take.played.empty()) {
        ClockTracker<DacClock> dac{take.dac_rate_hz};
        for (const PlayTime& p : take.played) follow(dac, p);
        row(0, dac, take.played.size());
    }
    if (!take.blocks.empty() && !take.played.empty()) {
        ClockTracker<AccelerometerClock> accelerometer{take.accelerometer.rate_hz};
        for (const AccelBlock& b : take.blocks) accelerometer.add({b.first.n + b.size - 1}, b.arrived);
        row(1, accelerometer, take.blocks.size());
    }
    for (std::size_t c = 0; c < take.cameras.size(); ++c) {
        const CameraTake& camera = take.cameras[c];
        if (camera.untimed.empty() || !(camera.view.frame_rate_hz > 0)) continue;
        ClockTracker<CameraClock> frames{camera.view.frame_rate_hz};
        for (const FrameStamp& f : camera.untimed) frames.add(f.tick, f.arrived);
        row(static_cast<double>(2 + c), frames, camera.untimed.size());
    }
    return table;
}

RecordedTable gap_table(const Take& take) {
    RecordedTable table{"gaps", {{"stream", "1", {}}, {"first", "1", {}}, {"count", "1", {}}}};
    const auto row = [&](std::size_t stream, std::int64_t first, std::int64_t count) {
        table.columns[0].values.push_back(static_cast<double>(stream));
        table.columns[1].values.push_back(static_cast<double>(first));
        table.columns[2].values.push_back(static_cast<double>(count));
    };
    for (const PlayTime& p : take.played)
        if (p.lost > 0) row(0, p.tick.n, p.lost);
    std::int64_t next = take.blocks.empty() ? 0 : take.blocks.front().first.n;
    for (const AccelBlock& b : take.blocks) {
        if (b.first.n != next) row(1, next, b.first.n - next);
        next = b.first.n + b.size;
    }
    for (std::size_t c = 0; c < take.cameras.size(); ++c) {
        if (take.cameras[c].view.targets.empty()) continue;
        const std::vector<Track>& frames = take.tracks[take.cameras[c].first_track].tracks;
        for (std::size_t i = 1; i < frames.size(); ++i)
            if (const std::int64_t n = frames[i].tick.n - frames[i - 1].tick.n - 1; n != 0)
                row(2 + c, frames[i - 1].tick.n + 1, n);
    }
    return table;
}

RecordedTable truth_table(const std::string& camera, const std::vector<PoseTruth>& poses) {
    return {"truth/" + camera,
            {column("frame", "1", poses, [](const PoseTruth& p) { return p.tick.n; }),
             column("t", "s", poses, [](const PoseTruth& p) { return seconds(p.time); }),
             column("x_base", "m", poses, [](const PoseTruth& p) { return p.base; }),
             column("x_walker", "m", poses, [](const PoseTruth& p) { return p.walker; })}};
}

std::vector<RecordedNumber> picture_numbers(const std::string& camera, const PictureCounts& counts) {
    const auto number = [&](const char* what, std::uint64_t n) {
        return RecordedNumber{fmt::format("pictures/{}/{}", camera, what), static_cast<double>(n), "1"};
    };
    return {number("produced", counts.produced), number("stored", counts.stored),
            number("dropped", counts.dropped), number("not_kept", counts.not_kept)};
}

void write(SessionWriter& file, const Reduction& reduction, double from_s, double to_s) {
    file.scalar("process/reduced_from", from_s);
    file.scalar("process/reduced_to", to_s);
    write(file, tables_of(reduction));
    write(file, numbers_of(reduction));
    file.texts("results/notes/text", reduction.notes);
}

void write(SessionWriter& file, const std::vector<RecordedNumber>& numbers) {
    for (const RecordedNumber& n : numbers) file.scalar(n.path, n.value);
}

void write(SessionWriter& file, const std::vector<RecordedTable>& tables) {
    for (const RecordedTable& t : tables) file.rows(t.path, t.columns);
}

std::vector<std::string> differences(const SessionReader& file, const std::vector<RecordedNumber>& numbers,
                                     const std::vector<RecordedTable>& tables) {
    std::vector<std::string> found;
    for (const RecordedNumber& n : numbers) {
        const double was = file.scalar(n.path);
        if (!same(was, n.value))
            found.push_back(fmt::format("{}: recorded {}, now {}", n.path, was, n.value));
    }
    for (const RecordedTable& t : tables) {
        const std::vector<Column> recorded = file.table(t.path);
        for (const Column& c : t.columns) {
            const std::vector<double>& was = values_of(recorded, c.name, t.path);
            if (was.size() != c.values.size()) {
                found.push_back(fmt::format("{}/{}: {} rows recorded, now {}", t.path, c.name, was.size(),
                                            c.values.size()));
                continue;
            }
            const auto [a, b] = std::ranges::mismatch(was, c.values, same);
            if (a != was.end())
                found.push_back(fmt::format("{}/{} row {}: recorded {}, now {}", t.path, c.name,
                                            a - was.begin(), *a, *b));
        }
    }
    return found;
}

void read_tracks(const SessionReader& file, const SessionHeader& header, Take& take) {
    for (const View& view : header.views) {
        for (const Target& target : view.targets) {
            TargetTrack t{view.camera, target, {}};
            const std::string path = track_path(t);
            const std::vector<Column> table = file.table(path);
            const auto& frame = values_of(table, "frame", path);
            t.tracks.resize(frame.size());
            const auto fill = [&](const char* name, auto&& set) {
                const auto& values = values_of(table, name, path);
                if (values.size() != frame.size())
                    throw InputError{"recording: table \"" + path + "\" has columns of different length"};
                for (std::size_t i = 0; i < frame.size(); ++i) set(t.tracks[i], values[i]);
            };
            fill("frame", [](Track& k, double v) { k.tick.n = static_cast<std::int64_t>(v); });
            fill("t", [](Track& k, double v) { k.time = master_time(v); });
            fill("x_px", [](Track& k, double v) { k.fix.x_px = v; });
            fill("y_px", [](Track& k, double v) { k.fix.y_px = v; });
            fill("sd_px", [](Track& k, double v) { k.fix.sd_px = v; });
            fill("x", [](Track& k, double v) { k.x_m = v; });
            fill("x_errors", [](Track& k, double v) { k.sd_m = v; });
            fill("state",
                 [](Track& k, double v) { k.fix.state = static_cast<TrackState>(static_cast<int>(v)); });
            for (Track& k : t.tracks) scale(k, view, target);
            take.tracks.push_back(std::move(t));
        }
    }
}

}  // namespace shaker
