#pragma once
// The recording: one HDF5 file in NeXus manner, written and read here and nowhere else.
//
//   /entry                      NXentry: title, definition of the default plot
//   /entry/process              program, version, settings as TOML, the scene if simulated
//   /entry/raw/drive            every drive change (enough to regenerate each sample; those with
//                               stop_samples > 0 are stops, see DriveChange), play times
//   /entry/raw/accelerometer    counts as they came, block stamps
//   /entry/raw/<camera>         frames (when kept), ticks, mid-exposure times, arrival stamps, view
//   /entry/raw/<camera>/tail    the pictures around a trip, where frames are not kept: frames, tick,
//                               mid_exposure
//   /entry/tracks/<camera>/<target>, /entry/periods, /entry/results, /entry/cycle, /entry/truth
//   /entry/identification       how the base answers to the drive
//   /entry/trips                why the drive was stopped; then /entry/process@ended_by_trip is 1
//
// A recording of kind "trip" holds the last seconds of a run of which nothing else was kept: ticks have the
// numbers they had in the run, the first block and the first frames are marked as coming after a gap.
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker {

/// Stands in raw/<camera>/stamp for a frame without one.
inline constexpr std::int64_t no_stamp = std::numeric_limits<std::int64_t>::min();

/// What a recording says about itself before the first sample.
struct SessionHeader {
    std::string title;
    std::string kind;         // "run" of shakerd, "trip": the end of a run, or "session" recorded elsewhere
    std::string config;       // settings as TOML
    std::string rig;          // TOML: a simulated scene, or the rig file of real devices
    double frequency_hz = 0;  // nominal
    DacInfo dac;              // rate 0: no DAC in this session
    AccelerometerInfo accelerometer;  // rate 0: none
    std::vector<View> views;
    bool keep_frames = true;
    bool ended_by_trip = false;  // as read; a writer is told by end_by_trip()
};

/// A column of a table: its name, its unit as UDUNITS text, and its values.
struct Column {
    std::string name;
    std::string units;
    std::vector<double> values;
};

class SessionWriter {
public:
    /// Creates (or replaces) the file. Throws DeviceError when that is not possible.
    SessionWriter(const std::filesystem::path& file, const SessionHeader& header);
    ~SessionWriter();
    void add(const PlayTime& played);
    void add(const DriveChange& change);
    void add(const AccelBlock& block);
    void add(std::size_t camera, const Frame& frame);
    /// A whole table under /entry, e.g. "tracks/top/walker"; attributes make it the default plot where
    /// wanted.
    void table(const std::string& path, const std::vector<Column>& columns,
               const std::string& nx_class = "NXcollection",
               const std::map<std::string, std::string>& attributes = {});
    /// A number under /entry with its unit.
    void scalar(const std::string& path, double value, const std::string& units);
    void text(const std::string& path, const std::string& text);
    /// A column of texts under /entry.
    void texts(const std::string& path, const std::vector<std::string>& texts);
    /// A picture of the last seconds, in a recording that keeps no frames.
    void tail(std::size_t camera, const Frame& frame);
    /// A limit stopped the drive; once.
    void end_by_trip();
    /// What a viewer shows first: the path of an NXdata group under /entry; once.
    void show(const std::string& path);
    /// Writes what waits in buffers; called by the owner before the file is complete.
    void flush();

private:
    struct Streams;
    std::unique_ptr<Streams> streams_;
};

/// Reads a recording; every error is an InputError that names the path inside the file.
class SessionReader {
public:
    explicit SessionReader(const std::filesystem::path& file);
    ~SessionReader();
    [[nodiscard]] const SessionHeader& header() const noexcept;
    [[nodiscard]] std::vector<PlayTime> play_times() const;
    [[nodiscard]] std::vector<DriveChange> changes() const;
    /// A table as it was written: columns in alphabetical order.
    [[nodiscard]] std::vector<Column> table(const std::string& path) const;
    [[nodiscard]] std::vector<std::string> names(const std::string& path) const;
    [[nodiscard]] double scalar(const std::string& path) const;
    [[nodiscard]] std::string text(const std::string& path) const;
    /// Columns of their own, for tables that hold both.
    [[nodiscard]] std::vector<double> numbers(const std::string& path) const;
    [[nodiscard]] std::vector<std::string> texts(const std::string& path) const;
    [[nodiscard]] bool has(const std::string& path) const;

    struct Opened;
    [[nodiscard]] const Opened& opened() const noexcept { return *opened_; }

private:
    std::unique_ptr<Opened> opened_;
};

/// The recorded streams as a Rig: accelerometer blocks and, where frames were kept, cameras. The reader
/// outlives it.
Rig replay_rig(const SessionReader& reader);

}  // namespace shaker
