#include "daemon/export/streams.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "calibration/clocks/timebase.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/played_drive.hpp"
#include "drivers/recorded/raw_columns.hpp"
#include "drivers/ticks.hpp"

namespace shaker::exporting {

namespace {

using Numbers = std::vector<double>;
using Integers = std::vector<std::int64_t>;

namespace raw = recorded::raw;

constexpr std::size_t rows_at_once = 65536;

// A column of the schema, under the name that a table of its stream has for it.
ExportColumn stored(const recorded::RawColumn& column, std::string name) {
    if (column.type == recorded::RawColumn::Type::float64) return {std::move(name), column.units, Numbers{}};
    return {std::move(name), column.units, Integers{}};
}
ExportColumn stored(const recorded::RawColumn& column) { return stored(column, column.name); }

// Master time of accelerometer samples.
class SampleTimes {
public:
    explicit SampleTimes(const recorded::RecordingReader& file, Accelerometer& blocks)
        : timebase_{{.dac_rate_hz = file.header().dac.rate_hz,
                     .accelerometer_rate_hz = file.header().accelerometer.rate_hz,
                     .first_sample_s = file.header().accelerometer.first_sample_s,
                     .cameras = {}}} {
        for (const PlayTime& p : file.play_times()) timebase_.add(p);
        AccelBlock block;
        while (blocks.read(block, std::chrono::milliseconds{0})) timebase_.add(block);
        const double ppm = file.scalar("results/accelerometer_ppm"),
                     late = file.scalar("results/accelerometer_late");
        if (!std::isfinite(ppm) || !std::isfinite(late)) return;
        rate_ = 1 + 1e-6 * ppm;
        late_s_ = late;
    }
    [[nodiscard]] double at(AccelTick tick) const { return rate_ * seconds(timebase_.at(tick)) - late_s_; }

private:
    calibration::Timebase timebase_;
    double rate_ = 1, late_s_ = 0;
};

template <class T>
void put(std::vector<ExportColumn>& columns, std::size_t column, T value) {
    std::get<std::vector<T>>(columns[column].values).push_back(value);
}

void empty(std::vector<ExportColumn>& columns) {
    for (ExportColumn& c : columns) std::visit([](auto& values) { values.clear(); }, c.values);
}

void add_block(const AccelBlock& block, const AccelerometerInfo& info, const SampleTimes& times,
               std::vector<ExportColumn>& columns) {
    for (int i = 0; i < block.size; ++i) {
        const auto& counts = block.counts[static_cast<std::size_t>(i)];
        const std::array<double, 3> a = info.acceleration(counts);
        put(columns, 0, times.at({block.first.n + i}));
        put(columns, 1, block.first.n + i);
        for (std::size_t k = 0; k < 3; ++k) {
            put(columns, 2 + k, a[k]);
            put(columns, 5 + k, std::int64_t{counts[k]});
        }
        put(columns, 8, static_cast<std::int64_t>(block.quality));
    }
}

// Last sample with a time from the DAC. The limit between two stamps exceeds the length of any block.
std::int64_t end_of(const std::vector<PlayTime>& played) {
    constexpr std::int64_t most = std::int64_t{1} << 20;
    std::int64_t before = 0, lost = 0;
    for (const PlayTime& p : played) {
        if (p.tick.n < before || lost < 0 || p.tick.n - before - most > lost)
            throw InputError{
                fmt::format("recording: raw/drive/play_tick {} comes after {}", p.tick.n, before)};
        before = p.tick.n;
        lost = p.lost;
    }
    return before;
}

struct DriveSamples {
    std::unique_ptr<recorded::PlayedDrive> drive;
    std::int64_t next = 0, end = 0;
    double rate_hz = 0;
};

DriveSamples samples_of(const recorded::RecordingReader& file) {
    const recorded::RecordingHeader& header = file.header();
    if (header.kind == "trip")
        throw InputError{file.file().string() +
                         ": the samples of the drive cannot be recomputed: the file holds only the last "
                         "changes of the run"};
    const std::vector<PlayTime> played = file.play_times();
    return {std::make_unique<recorded::PlayedDrive>(header.dac, header.frequency_hz, file.changes(), played),
            0, end_of(played), header.dac.rate_hz};
}

// Returns all rows in one piece.
ExportTable at_once(std::string name, std::vector<ExportColumn> headings,
                    std::function<void(std::vector<ExportColumn>&)> read) {
    return {std::move(name), std::move(headings),
            [read = std::move(read), done = false](std::vector<ExportColumn>& columns) mutable {
                if (std::exchange(done, true)) return false;
                read(columns);
                return true;
            }};
}

}  // namespace

ExportTable accelerometer_table(const recorded::RecordingReader& file) {
    struct State {
        Rig rig;
        SampleTimes times;
    };
    std::vector<ExportColumn> headings{{"t", "s", Numbers{}}, {"sample", "1", Integers{}}};
    for (const char axis : {'x', 'y', 'z'})
        headings.push_back({fmt::format("a_{}", axis), "m/s^2", Numbers{}});
    for (const char axis : {'x', 'y', 'z'})
        headings.push_back(stored(raw::counts, fmt::format("{}_{}", raw::counts.name, axis)));
    headings.push_back(stored(raw::block_quality, "quality"));
    return {"accelerometer", headings,
            [&file, state = std::shared_ptr<State>{}](std::vector<ExportColumn>& columns) mutable {
                if (!state) {
                    Rig once = replay_rig(file, file.header(), false);
                    SampleTimes times{file, *once.accelerometer};
                    state = std::make_shared<State>(
                        State{replay_rig(file, file.header(), false), std::move(times)});
                }
                empty(columns);
                AccelBlock block;
                while (rows_of(columns) < rows_at_once &&
                       state->rig.accelerometer->read(block, std::chrono::milliseconds{0}))
                    add_block(block, file.header().accelerometer, state->times, columns);
                return rows_of(columns) > 0;
            }};
}

ExportTable drive_table(const recorded::RecordingReader& file) {
    return {"drive",
            {{"t", "s", Numbers{}}, {"sample", "1", Integers{}}, {"volts", "V", Numbers{}}},
            [&file, state = std::shared_ptr<DriveSamples>{}](std::vector<ExportColumn>& columns) mutable {
                if (!state) state = std::make_shared<DriveSamples>(samples_of(file));
                empty(columns);
                Numbers volts(std::min(rows_at_once, static_cast<std::size_t>(state->end - state->next)));
                state->drive->fill(volts);
                for (std::size_t i = 0; i < volts.size(); ++i, ++state->next) {
                    put(columns, 0, counted_s(DacTick{state->next}, state->rate_hz));
                    put(columns, 1, state->next);
                }
                columns[2].values = std::move(volts);
                return rows_of(columns) > 0;
            }};
}

ExportTable changes_table(const recorded::RecordingReader& file) {
    std::vector<ExportColumn> headings{stored(raw::first_tick), stored(raw::ramp_samples),
                                       stored(raw::stop_samples), stored(raw::taken_back),
                                       stored(raw::frequency)};
    for (int q = 1; q <= max_harmonics; ++q) {
        headings.push_back(stored(raw::harmonics_re, fmt::format("re_{}", q)));
        headings.push_back(stored(raw::harmonics_im, fmt::format("im_{}", q)));
    }
    return at_once("changes", std::move(headings), [&file](std::vector<ExportColumn>& columns) {
        for (const DriveChange& c : file.changes()) {
            put(columns, 0, c.first.n);
            put(columns, 1, c.ramp);
            put(columns, 2, c.stop);
            put(columns, 3, c.taken_back);
            put(columns, 4, c.command.frequency);
            for (std::size_t q = 0; q < max_harmonics; ++q) {
                put(columns, 5 + 2 * q, c.command.volts.a[q].real());
                put(columns, 6 + 2 * q, c.command.volts.a[q].imag());
            }
        }
    });
}

ExportTable plays_table(const recorded::RecordingReader& file) {
    return at_once(
        "plays",
        {stored(raw::play_tick, "tick"), stored(raw::play_heard, "heard"), stored(raw::play_lost, "lost")},
        [&file](std::vector<ExportColumn>& columns) {
            for (const PlayTime& p : file.play_times()) {
                put(columns, 0, p.tick.n);
                put(columns, 1, std::int64_t{p.heard.time_since_epoch().count()});
                put(columns, 2, p.lost);
            }
        });
}

ExportTable frames_table(const recorded::RecordingReader& file, const std::string& camera) {
    return at_once("frames/" + camera,
                   {stored(raw::tick), stored(raw::mid_exposure), stored(raw::arrived), stored(raw::stamp),
                    stored(raw::quality), stored(raw::picture)},
                   [&file, camera](std::vector<ExportColumn>& columns) {
                       const std::vector<Frame> frames = file.frames(camera);
                       const std::vector<std::uint64_t> pictures = file.pictures_of(camera);
                       if (pictures.size() != frames.size())
                           throw InputError{"recording: raw/" + camera + " has columns of different length"};
                       for (std::size_t i = 0; i < frames.size(); ++i) {
                           const Frame& f = frames[i];
                           put(columns, 0, f.tick.n);
                           put(columns, 1, f.mid_exposure ? seconds(*f.mid_exposure) : double{NAN});
                           put(columns, 2, std::int64_t{f.arrived.time_since_epoch().count()});
                           put(columns, 3, f.stamp ? f.stamp->n : pictures::no_stamp);
                           put(columns, 4, static_cast<std::int64_t>(f.quality));
                           put(columns, 5, static_cast<std::int64_t>(pictures[i]));
                       }
                   });
}

}  // namespace shaker::exporting
