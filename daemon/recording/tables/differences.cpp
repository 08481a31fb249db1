#include "daemon/recording/tables/differences.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/track_table.hpp"
#include "drivers/errors.hpp"

namespace shaker::recording {

namespace {

bool same(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
           (std::isnan(a) && std::isnan(b));
}

const std::vector<double>& values_of(const std::vector<recorded::Column>& columns, const std::string& name,
                                     const std::string& path) {
    const auto it = std::ranges::find(columns, name, &recorded::Column::name);
    if (it == columns.end())
        throw InputError{"recording: table \"" + path + "\" has no column \"" + name + "\""};
    return it->values;
}

// " (measurement 3)" in a table with rows of several measurements, otherwise empty.
std::string measurement_at(const RecordedTable& table, std::size_t row) {
    if (table.columns.front().name != measurement_column) return {};
    return fmt::format(" (measurement {})", table.columns.front().values[row]);
}

// Places in px; `states`: pictures in which a target is in another state (found, degraded, lost).
struct Moved {
    double squares = 0, most = 0, variances = 0;
    std::size_t both = 0, states = 0;
};

Moved between(const std::vector<tracking::Track>& then, const std::vector<tracking::Track>& now) {
    Moved m;
    for (std::size_t i = 0; i < std::min(then.size(), now.size()); ++i) {
        const tracking::Fix &a = then[i].fix, &b = now[i].fix;
        m.states += a.state != b.state ? 1 : 0;
        const double distance = std::hypot(b.x_px - a.x_px, b.y_px - a.y_px);
        if (!std::isfinite(distance)) continue;
        ++m.both;
        m.squares += distance * distance;
        m.most = std::max(m.most, distance);
        m.variances += b.sd_px * b.sd_px;
    }
    return m;
}

}  // namespace

std::vector<std::string> differences(const recorded::RecordingReader& file,
                                     const std::vector<RecordedNumber>& numbers,
                                     const std::vector<RecordedTable>& tables) {
    std::vector<std::string> found;
    for (const RecordedNumber& n : numbers) {
        const double was = file.scalar(n.path);
        if (!same(was, n.value))
            found.push_back(fmt::format("{}: recorded {}, now {}", n.path, was, n.value));
    }
    for (const RecordedTable& t : tables) {
        const std::vector<recorded::Column> recorded = file.table(t.path);
        for (const recorded::Column& c : t.columns) {
            const std::vector<double>& was = values_of(recorded, c.name, t.path);
            if (was.size() != c.values.size()) {
                found.push_back(fmt::format("{}/{}: {} rows recorded, now {}", t.path, c.name, was.size(),
                                            c.values.size()));
                continue;
            }
            const auto [a, b] = std::ranges::mismatch(was, c.values, same);
            if (a == was.end()) continue;
            const auto row = static_cast<std::size_t>(a - was.begin());
            found.push_back(fmt::format("{}/{} row {}{}: recorded {}, now {}", t.path, c.name, row,
                                        measurement_at(t, row), *a, *b));
        }
    }
    return found;
}

std::vector<std::string> track_changes(const recorded::RecordingReader& file,
                                       const acquisition::Streams& now) {
    acquisition::Streams then;
    read_tracks(file, file.header(), then);
    std::vector<std::string> changes;
    for (std::size_t i = 0; i < std::min(then.tracks.size(), now.tracks.size()); ++i) {
        const acquisition::TargetTrack& t = now.tracks[i];
        const Moved m = between(then.tracks[i].tracks, t.tracks);
        if (m.most == 0 && m.states == 0) continue;
        const double n = static_cast<double>(std::max<std::size_t>(m.both, 1));
        changes.push_back(fmt::format(
            "{}: {:.2g} px rms, at most {:.2g} (stated error {:.2g}); another state in {} of {} pictures",
            track_path(t.camera, t.target), std::sqrt(m.squares / n), m.most, std::sqrt(m.variances / n),
            m.states, t.tracks.size()));
    }
    return changes;
}

}  // namespace shaker::recording
