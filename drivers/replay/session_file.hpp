#pragma once
// The recording: an HDF5 file in NeXus manner, written and read here and nowhere else. Others may read it
// while it is written (HDF5's single writer, many readers). Pictures lie beside it, see frame_store.hpp.
//
//   /entry                      NXentry: title, start and end, definition, the default plot
//   /entry/process              program, version, settings as TOML and their SHA-256, the scene or rig file
//   /entry/raw/drive            every drive change (enough to regenerate each sample; those with
//                               stop_samples > 0 are stops, see DriveChange), play times
//   /entry/raw/accelerometer    counts as they came, block stamps
//   /entry/raw/<camera>         of every frame: tick, mid-exposure time, arrival and camera stamps, quality,
//   the
//                               number of its picture (0: it was not kept); the view
//   /entry/seals                checksums of what was written, piece by piece: see seals.hpp
//   what the header's groups say: tracks, states, events, results, ...
//
// A recording of kind "trip" holds the last seconds of a run of which nothing else was kept: ticks have the
// numbers they had in the run, the first block and the first frames are marked as coming after a gap.
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/replay/session_layout.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker {

/// Stands in raw/<camera>/stamp for a frame without one.
inline constexpr std::int64_t no_stamp = std::numeric_limits<std::int64_t>::min();

/// Which pictures a recording keeps: none; of each the region its targets can be in; whole ones.
enum class KeptPictures { off, region, full };
/// "off", "region", "full".
const char* name(KeptPictures kept) noexcept;
/// The one of such a word; none for any other.
std::optional<KeptPictures> kept_pictures_named(const std::string& word) noexcept;

/// What a recording says about itself before the first sample.
struct SessionHeader {
    std::string title;
    std::string kind;          // "run" of shakerd, "trip": the end of a run, or "session" recorded elsewhere
    std::string config;        // settings as TOML
    std::string rig;           // TOML: a simulated scene, or the rig file of real devices
    std::string started;       // ISO 8601 with offset; of a simulated run: the epoch, so that runs are equal
    std::string identifier;    // of this recording and no other; empty where there is none
    std::string user, sample;  // names, for NeXus; may be empty
    double frequency_hz = 0;   // nominal
    DacInfo dac;               // rate 0: no DAC in this session
    AccelerometerInfo accelerometer;  // rate 0: none
    std::vector<View> views;          // as the kept pictures show them
    KeptPictures pictures = KeptPictures::region;
    std::vector<GroupLayout> groups;  // beside the raw streams; a reader leaves them empty
};

/// Where the pictures of a recording are: "run.frames" beside "run.nxs" and "run.nxs.part".
std::filesystem::path pictures_folder(std::filesystem::path recording);

class SessionWriter {
public:
    /// Creates (or replaces) the file with all its places and lets others read it from then on. Throws
    /// DeviceError when that is not possible.
    SessionWriter(const std::filesystem::path& file, const SessionHeader& header);
    /// Goes on with a copy of a file whose writer died, cut to what can be vouched for: each column to its
    /// last whole seal, and those that belong together to the same length. It takes no more of the streams.
    /// InputError when nothing of it can be vouched for.
    static SessionWriter mend(const std::filesystem::path& copy);
    SessionWriter(SessionWriter&&) noexcept;
    SessionWriter& operator=(SessionWriter&&) noexcept;
    ~SessionWriter();
    void add(const PlayTime& played);
    void add(const DriveChange& change);
    void add(const AccelBlock& block);
    /// A frame without its pixels; picture: the number it is kept under, 0: it is not.
    void add(std::size_t camera, const Frame& frame, std::uint64_t picture);
    /// The columns of a group that grow, in the layout's order, for row().
    [[nodiscard]] std::size_t table(const std::string& path) const;
    /// One row of such numbers.
    void row(std::size_t table, std::span<const double> values);
    /// Whole columns at the end of those that are there. DeviceError for one that has no place.
    void rows(const std::string& path, const std::vector<Column>& columns);
    void texts(const std::string& path, const std::vector<std::string>& texts);
    /// Other values in place of those of a provisional column, or of any before its first seal.
    void replace(const std::string& path, const std::vector<double>& values);
    /// Other picture numbers for all of a camera's frames.
    void replace_pictures(const std::string& camera, const std::vector<std::uint64_t>& pictures);
    /// Empties the columns of a group, before the first seal of a mended file.
    void clear(const std::string& path);
    void scalar(const std::string& path, double value);
    void text(const std::string& path, const std::string& text);
    /// Writes what waits in buffers and seals it: readers see it then.
    void flush();
    /// What was flushed is on the disk when this returns.
    void sync();
    /// flush(), sync() and nothing more is taken. Throws DeviceError when the file is not whole.
    void close();

private:
    struct Streams;
    explicit SessionWriter(std::unique_ptr<Streams> streams);
    std::unique_ptr<Streams> streams_;
};

/// Reads a recording; every error is an InputError that names the path inside the file.
class SessionReader {
public:
    /// One that is still being written: what it held at its last flush.
    enum class Open { finished, growing };
    explicit SessionReader(const std::filesystem::path& file, Open open = Open::finished);
    ~SessionReader();
    [[nodiscard]] const SessionHeader& header() const noexcept;
    [[nodiscard]] std::vector<PlayTime> play_times() const;
    [[nodiscard]] std::vector<DriveChange> changes() const;
    /// A table's columns of numbers, in alphabetical order.
    [[nodiscard]] std::vector<Column> table(const std::string& path) const;
    [[nodiscard]] std::vector<std::string> names(const std::string& path) const;
    /// NaN: it was not known.
    [[nodiscard]] double scalar(const std::string& path) const;
    [[nodiscard]] std::string text(const std::string& path) const;
    /// Columns of their own, for tables that hold both.
    [[nodiscard]] std::vector<double> numbers(const std::string& path) const;
    [[nodiscard]] std::vector<std::string> texts(const std::string& path) const;
    [[nodiscard]] bool has(const std::string& path) const;
    /// Where the file is not what was written, one sentence each: every column is read and held against its
    /// seals.
    [[nodiscard]] std::vector<std::string> damage() const;
    /// A camera's frames without their pixels.
    [[nodiscard]] std::vector<Frame> frames(const std::string& camera) const;
    /// Of each of a camera's frames the number of its picture; 0: none was kept.
    [[nodiscard]] std::vector<std::uint64_t> pictures_of(const std::string& camera) const;
    /// Frames of which no picture was kept; all of them where none were to be.
    [[nodiscard]] std::uint64_t frames_without_picture() const;
    [[nodiscard]] const std::filesystem::path& file() const noexcept;

    struct Opened;
    [[nodiscard]] const Opened& opened() const noexcept { return *opened_; }

private:
    std::unique_ptr<Opened> opened_;
};

/// The recorded streams as a Rig: accelerometer blocks and, from pictures, cameras. header: the reader's own,
/// or with other scales. The reader outlives it.
Rig replay_rig(const SessionReader& reader, const SessionHeader& header, bool pictures);

}  // namespace shaker
