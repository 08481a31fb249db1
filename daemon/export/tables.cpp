#include "daemon/export/tables.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <memory>
#include <set>
#include <utility>

#include "calibration/clocks/timebase.hpp"
#include "daemon/recording/tables/places.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/played_drive.hpp"
#include "drivers/recorded/raw_columns.hpp"
#include "drivers/time.hpp"

namespace shaker::exporting {

namespace {

constexpr const char* on_request = "drive";  // very large, so only exported if named

std::string path_of(const recorded::GroupLayout& group, const recorded::Place& place) {
    return group.path + "/" + place.name;
}

ExportColumn heading_of(const recorded::Place& place) {
    const bool text = place.kind == recorded::Place::Kind::text || place.kind == recorded::Place::Kind::texts;
    ExportColumn column{place.name, place.units, std::vector<double>{}};
    if (text) column.values = std::vector<std::string>{};
    return column;
}

void read(const recorded::RecordingReader& file, const std::string& path, recorded::Place::Kind kind,
          ExportColumn& column) {
    switch (kind) {
        case recorded::Place::Kind::number:
            column.values = std::vector<double>{file.scalar(path)};
            break;
        case recorded::Place::Kind::text:
            column.values = std::vector<std::string>{file.text(path)};
            break;
        case recorded::Place::Kind::numbers:
            column.values = file.numbers(path);
            break;
        case recorded::Place::Kind::texts:
            column.values = file.texts(path);
            break;
    }
}

// The columns of a group; single numbers and texts form one row.
ExportTable stored_table(const recorded::RecordingReader& file, const recorded::GroupLayout& group) {
    std::vector<ExportColumn> headings;
    for (const recorded::Place& p : group.places) headings.push_back(heading_of(p));
    return {group.path, std::move(headings),
            [&file, group, done = false](std::vector<ExportColumn>& columns) mutable {
                if (std::exchange(done, true)) return false;
                for (std::size_t i = 0; i < columns.size(); ++i) {
                    read(file, path_of(group, group.places[i]), group.places[i].kind, columns[i]);
                    const auto rows = std::visit([](const auto& v) { return v.size(); }, columns[i].values);
                    if (rows != rows_of(columns))
                        throw InputError{"recording: " + group.path + " has columns of different length"};
                }
                return true;
            }};
}

bool is_there(const recorded::RecordingReader& file, const recorded::GroupLayout& group) {
    return !group.places.empty() && std::ranges::all_of(group.places, [&](const recorded::Place& p) {
        return file.has(path_of(group, p));
    });
}

std::string word_of(const ExportTable& table) { return table.name.substr(0, table.name.find('/')); }

using Numbers = std::vector<double>;
using Integers = std::vector<std::int64_t>;

namespace raw = recorded::raw;

constexpr std::size_t rows_at_once = 65536;

// A column of the schema, under the name that a table of its stream has for it.
ExportColumn stored(const recorded::RawColumn& column, std::string name) {
    if (column.type == recorded::RawColumn::Type::float64) return {std::move(name), column.units, Numbers{}};
    return {std::move(name), column.units, Integers{}};
}

// Master time of accelerometer samples.
class SampleTimes {
public:
    explicit SampleTimes(const recorded::RecordingReader& file, Accelerometer& blocks)
        : timebase_{{.dac_rate_hz = file.header().dac.rate_hz,
                     .accelerometer_rate_hz = file.header().accelerometer.rate_hz,
                     .first_sample_s = file.header().accelerometer.first_sample_s,
                     .dac_clock = file.header().accelerometer.dac_clock,
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
            put(columns, 2 + k, k < static_cast<std::size_t>(info.axes) ? a[k] : NAN);
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

// "accelerometer": m/s^2 in the axes of the sensor and raw counts, on master time. Times come from the
// stamps, corrected by the delay of the sensor if the results contain it.
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

// "drive": each sample given to the DAC, recomputed from the changes. Reading throws InputError if the file
// does not contain all changes.
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

/// One value of a column under the name that a table has for it.
template <class Row>
struct Stored {
    recorded::RawColumnOf<Row> column;
    std::string name;
    std::size_t value = 0;
};

template <class Row>
void put_row(std::vector<ExportColumn>& columns, std::span<const Stored<Row>> stored_columns,
             const Row& row) {
    std::array<std::byte, max_harmonics * sizeof(double)> values;  // of the widest column
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const Stored<Row>& s = stored_columns[i];
        s.column.get(row, values.data());
        recorded::with_zero(s.column.type, [&](auto number) {
            std::memcpy(&number, values.data() + s.value * sizeof number, sizeof number);
            if constexpr (std::same_as<decltype(number), double>)
                put(columns, i, number);
            else
                put(columns, i, static_cast<std::int64_t>(number));
        });
    }
}

/// A table of stored columns. rows: returns all rows.
template <class Row>
ExportTable stored_table(std::string name, std::vector<Stored<Row>> stored_columns,
                         std::function<std::vector<Row>()> rows) {
    std::vector<ExportColumn> headings;
    for (const Stored<Row>& s : stored_columns) headings.push_back(stored(s.column, s.name));
    return {std::move(name), std::move(headings),
            [stored_columns = std::move(stored_columns), rows = std::move(rows),
             done = false](std::vector<ExportColumn>& columns) mutable {
                if (std::exchange(done, true)) return false;
                for (const Row& row : rows()) put_row<Row>(columns, stored_columns, row);
                return true;
            }};
}

// "changes": all changes of the drive, with harmonics.
ExportTable changes_table(const recorded::RecordingReader& file) {
    std::vector<Stored<DriveChange>> columns;
    for (const auto& c :
         {raw::first_tick, raw::ramp_samples, raw::stop_samples, raw::taken_back, raw::frequency})
        columns.push_back({c, c.name});
    for (std::size_t q = 1; q <= max_harmonics; ++q) {
        columns.push_back({raw::harmonics_re, fmt::format("re_{}", q), q - 1});
        columns.push_back({raw::harmonics_im, fmt::format("im_{}", q), q - 1});
    }
    return stored_table<DriveChange>("changes", std::move(columns), [&file] { return file.changes(); });
}

// "plays": times at which samples of the drive were played.
ExportTable plays_table(const recorded::RecordingReader& file) {
    std::vector<Stored<PlayTime>> columns;
    for (const auto& c : raw::plays) columns.push_back({c, std::string{c.name}.substr(5)});  // "play_"
    return stored_table<PlayTime>("plays", std::move(columns), [&file] { return file.play_times(); });
}

// "frames/<camera>": all stamps; picture 0: no picture was kept.
ExportTable frames_table(const recorded::RecordingReader& file, const std::string& camera) {
    std::vector<Stored<recorded::RawFrame>> columns;
    for (const auto& c : raw::frames) columns.push_back({c, c.name});
    std::rotate(columns.begin() + 1, columns.begin() + 3, columns.begin() + 4);  // both times side by side
    return stored_table<recorded::RawFrame>("frames/" + camera, std::move(columns),
                                            [&file, camera] { return file.frame_rows(camera); });
}

}  // namespace

std::size_t rows_of(const std::vector<ExportColumn>& columns) {
    return columns.empty() ? 0 : std::visit([](const auto& v) { return v.size(); }, columns.front().values);
}

std::vector<ExportTable> export_tables(const recorded::RecordingReader& file) {
    const recorded::RecordingHeader& header = file.header();
    std::vector<ExportTable> tables;
    for (const recorded::GroupLayout& group : recording::recording_places(header, file.has("truth")))
        if (is_there(file, group)) tables.push_back(stored_table(file, group));
    if (header.accelerometer.rate_hz > 0) tables.push_back(accelerometer_table(file));
    for (const View& view : header.views) tables.push_back(frames_table(file, view.camera));
    if (header.dac.rate_hz > 0) {
        tables.push_back(changes_table(file));
        tables.push_back(plays_table(file));
        tables.push_back(drive_table(file));
    }
    return tables;
}

std::vector<ExportTable> chosen(std::vector<ExportTable> tables, const std::vector<std::string>& what,
                                const std::filesystem::path& file) {
    std::set<std::string> words, wanted{what.begin(), what.end()};
    for (const ExportTable& t : tables) words.insert(word_of(t));
    if (wanted.erase("all") > 0)
        std::ranges::copy_if(words, std::inserter(wanted, wanted.end()),
                             [](const std::string& word) { return word != on_request; });
    for (const std::string& word : wanted)
        if (!words.contains(word))
            throw InputError{
                fmt::format("--what {}: {} has no such table; it has {}; \"all\" is every table except {}",
                            word, file.string(), fmt::join(words, ", "), on_request)};
    std::erase_if(tables, [&](const ExportTable& t) { return !wanted.contains(word_of(t)); });
    return tables;
}

}  // namespace shaker::exporting
