#pragma once
// RecordingWriter and RecordingReader: recordings as HDF5 files in NeXus layout. Other processes may read a
// file while it is written (HDF5's single writer, many readers). Pictures are stored beside it, see
// pictures/picture_store.hpp.
//
// The page for users of the format is daemon/recording/FORMAT.md. This room knows two parts of a file:
//
//   the frame: title, times, program, settings, devices and views as attributes, seals
//   the raw streams, whose columns stand in raw_columns.hpp: drive, accelerometer, frames
//
// All other groups and columns are those that the header names (RecordingHeader::groups). They are made,
// filled and read here without knowing them. Their names, units and meanings stand in
// daemon/recording/tables. The header carries the version of their layout.
//
// Each flush adds a seal, see seals.hpp: what a crash leaves is cut to the last whole one.
//
// A recording of kind "trip" holds only the last seconds of a run: ticks are those of the run, and the first
// block and frames are marked as following a gap.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/recorded/pictures/picture_record.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker::recorded {

/// One data set of a recording. Every group and data set is created before the first sample, because no
/// objects can be added to a file that other processes read while it grows.
struct Place {
    enum class Kind {
        number,   // single, 64-bit float; NaN while unknown
        text,     // single, fixed length; empty while unknown
        numbers,  // growing column, 64-bit float
        texts,    // growing column, fixed length
    };
    std::string name;
    std::string units;  // UDUNITS text; for a text: empty
    Kind kind = Kind::numbers;
    std::size_t text_bytes = 0;  // length of the longest text
    bool provisional = false;    // its rows are replaced when the recording is completed, so it is not sealed
    std::string meaning{};       // one phrase for readers of the format; not stored in the file
};

/// A group under /entry with its data sets.
struct GroupLayout {
    std::string path;
    std::string nx_class = "NXcollection";
    std::map<std::string, std::string> attributes;  // "signal", "axes", "title"
    std::vector<Place> places;
    double rows_per_s = 0;  // approximate rate of its columns; 0: few rows
    std::string meaning{};  // as of a place
};

/// A column of a table. units: UDUNITS text.
struct Column {
    std::string name;
    std::string units;
    std::vector<double> values;
};

struct RawFrame;

/// Pictures kept in a recording: none; those of the first second; all, of the region in which targets can
/// be; all, whole.
enum class KeptPictures { off, first_second, region, full };
/// The words for these, in the same order.
inline constexpr std::array<std::string_view, 4> kept_pictures_words{"off", "first-second", "region", "full"};
std::string_view name(KeptPictures kept) noexcept;
/// The value for a word; empty for any other.
std::optional<KeptPictures> kept_pictures_named(std::string_view word) noexcept;
/// True when every picture is kept, so that tracks can be computed from them.
constexpr bool keeps_all(KeptPictures kept) noexcept { return kept >= KeptPictures::region; }
/// Frames of a view in the first second, at least one.
std::int64_t first_second_frames(const View& view) noexcept;

/// Metadata of a recording that are known before the first sample.
struct RecordingHeader {
    std::string title;
    std::string kind;    // "run": by shakerd; "trip": the end of a run; "session": recorded elsewhere
    std::string config;  // settings as TOML
    std::string rig;     // TOML: a simulated scene, or the rig file of real devices
    std::string mixers;  // controls of the sound cards at the opening; empty: none
    /// ISO 8601 with offset; simulated run: the epoch, so that equal runs give equal files.
    std::string started;
    std::string identifier;           // unique to this recording; may be empty
    std::string user, sample;         // names, for NeXus; may be empty
    double frequency_hz = 0;          // nominal
    DacInfo dac;                      // rate 0: no DAC
    AccelerometerInfo accelerometer;  // rate 0: none
    std::vector<View> views;          // as in the kept pictures
    KeptPictures pictures = KeptPictures::region;
    int schema = 1;                   // version of the groups' layout: process@schema, 1 where there is none
    std::vector<GroupLayout> groups;  // besides the raw streams; a reader leaves them empty
};

/// Folder of a recording's pictures: "run.frames" for "run.nxs" and "run.nxs.part".
std::filesystem::path pictures_folder(std::filesystem::path recording);

class RecordingWriter {
public:
    /// Creates the file with all its data sets, readable by other processes from then on, and locks it for
    /// the life of this object. InputError when the file exists, DeviceError when it cannot be created.
    RecordingWriter(const std::filesystem::path& file, const RecordingHeader& header);
    /// Continues a copy of a file whose writer died, cut to its verified part: each column to its last whole
    /// seal, and columns that belong together to equal length. No streams can be added. InputError when no
    /// part can be verified.
    static RecordingWriter mend(const std::filesystem::path& copy);
    RecordingWriter(RecordingWriter&&) noexcept;
    RecordingWriter& operator=(RecordingWriter&&) noexcept;
    ~RecordingWriter();
    void add(const PlayTime& played);
    void add(const DriveChange& change);
    void add(const AccelBlock& block);
    /// A frame without its pixels. picture: number of its stored picture; 0: not stored.
    void add(std::size_t camera, const Frame& frame, std::uint64_t picture);
    /// Number of the growing columns of a group, in the layout's order, for row().
    [[nodiscard]] std::size_t table(const std::string& path) const;
    /// Adds one row of such columns.
    void row(std::size_t table, std::span<const double> values);
    /// Appends whole columns. DeviceError for a column without a place.
    void rows(const std::string& path, const std::vector<Column>& columns);
    void texts(const std::string& path, const std::vector<std::string>& texts);
    /// Replaces the values of a provisional column, or of any column before its first seal.
    void replace(const std::string& path, const std::vector<double>& values);
    /// Replaces the picture numbers of all frames of a camera.
    void replace_pictures(const std::string& camera, const std::vector<std::uint64_t>& pictures);
    /// True if the layout has a growing column of this path.
    [[nodiscard]] bool has(const std::string& path) const;
    /// Empties the columns of a group, before the first seal of a mended file.
    void clear(const std::string& path);
    void scalar(const std::string& path, double value);
    void text(const std::string& path, const std::string& text);
    /// Rows `first` to `first + count` of a column. DeviceError when they do not exist or the disk failed.
    [[nodiscard]] std::vector<double> numbers(const std::string& path, std::size_t first, std::size_t count);
    /// Added accelerometer blocks from number `first` on. first_sample: number of samples before them.
    [[nodiscard]] std::vector<AccelBlock> blocks(std::size_t first, std::size_t count,
                                                 std::size_t first_sample);
    /// Writes buffered data and seals it: readers see it then.
    void flush();
    /// Returns when all flushed data are on the disk.
    void sync();
    /// flush() and sync(); nothing can be added afterwards. Throws DeviceError when the file is incomplete.
    void close();

private:
    struct Streams;
    explicit RecordingWriter(std::unique_ptr<Streams> streams);
    std::unique_ptr<Streams> streams_;
};

/// Reads a recording. Every error is an InputError with the path inside the file.
class RecordingReader {
public:
    /// growing: the file is still being written; shows its state at the last flush.
    enum class Open { finished, growing };
    explicit RecordingReader(const std::filesystem::path& file, Open open = Open::finished);
    ~RecordingReader();
    [[nodiscard]] const RecordingHeader& header() const noexcept;
    [[nodiscard]] std::vector<PlayTime> play_times() const;
    [[nodiscard]] std::vector<DriveChange> changes() const;
    /// The number columns of a table, in alphabetical order.
    [[nodiscard]] std::vector<Column> table(const std::string& path) const;
    [[nodiscard]] std::vector<std::string> names(const std::string& path) const;
    /// NaN: unknown.
    [[nodiscard]] double scalar(const std::string& path) const;
    [[nodiscard]] std::string text(const std::string& path) const;
    /// Single columns, for tables with numbers and texts.
    [[nodiscard]] std::vector<double> numbers(const std::string& path) const;
    [[nodiscard]] std::vector<std::string> texts(const std::string& path) const;
    [[nodiscard]] bool has(const std::string& path) const;
    /// Damage of the file, one sentence each. Reads every column and checks it against its seals.
    [[nodiscard]] std::vector<std::string> damage() const;
    /// The stored columns of a camera's frames.
    [[nodiscard]] std::vector<RawFrame> frame_rows(const std::string& camera) const;
    /// The frames of a camera, with sightings but without pixels.
    [[nodiscard]] std::vector<Frame> frames(const std::string& camera) const;
    /// For each frame of a camera the number of its picture; 0: not stored.
    [[nodiscard]] std::vector<std::uint64_t> pictures_of(const std::string& camera) const;
    /// Number of frames without stored picture, of the cameras that give pictures; all of these frames if no
    /// pictures were to be stored.
    [[nodiscard]] std::uint64_t frames_without_picture() const;
    [[nodiscard]] const std::filesystem::path& file() const noexcept;

    struct Opened;
    [[nodiscard]] const Opened& opened() const noexcept { return *opened_; }

private:
    std::unique_ptr<Opened> opened_;
};

/// The recorded streams as a Rig: accelerometer blocks and, from pictures or sightings, cameras. header: the
/// reader's own, or one with other scales. The reader must outlive the rig.
Rig replay_rig(const RecordingReader& reader, const RecordingHeader& header, bool pictures);

}  // namespace shaker::recorded
