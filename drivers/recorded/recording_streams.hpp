#pragma once
// Internal state of a RecordingWriter, used for new and for mended files.
#include <list>
#include <map>
#include <optional>

#include "drivers/recorded/h5/crc32c.hpp"
#include "drivers/recorded/h5/file_lock.hpp"
#include "drivers/recorded/h5/seals.hpp"
#include "drivers/recorded/raw_columns.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recorded {

// A number or text that is written once.
struct Once {
    h5::Handle set, type;
    std::size_t column;  // number under the seals
    hsize_t written = 0;
    std::int64_t checksum = 0;

    void write(std::span<const std::byte> value, const std::string& path) {
        h5::check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, value.data()), path);
        checksum = h5::crc32c(value);
        written = 1;
    }
};

// A column and its number in the seals.
struct Numbered {
    h5::Growing data;
    std::size_t column;
    bool provisional = false;
};

struct RecordingWriter::Streams {
    struct CameraStream {
        std::vector<Numbered*> frames;
        Numbered* sightings = nullptr;  // of a camera that gives positions
    };
    h5::FileLock lock;  // released after all handles are closed
    h5::Handle file, entry;
    std::string name;
    std::vector<std::string> columns;  // paths, indexed by number
    std::list<Numbered> growing;       // in order of creation
    std::map<std::string, Numbered*> by_path;
    std::map<std::string, Once> once;
    std::vector<std::vector<Numbered*>> tables;
    std::map<std::string, std::size_t> table_of;
    // In the order of raw_columns.hpp.
    std::vector<Numbered*> plays, changes, blocks;
    Numbered* counts;
    std::vector<CameraStream> cameras;
    std::optional<h5::SealWriter> seals;

    Numbered* grow(const std::string& path, hid_t type, std::vector<hsize_t> row, double rows_per_s,
                   const std::string& units, bool provisional = false);
    Numbered* grow(const RawColumn& column, double rows_per_s, const std::string& path);
    /// camera: of a camera's columns.
    template <class Row>
    std::vector<Numbered*> grow(std::span<const RawColumnOf<Row>> row, double rows_per_s,
                                const std::string& camera = {});
    /// All that stands before the first data.
    void write_head(const RecordingHeader& header);
    void begin(const RecordingHeader& header);
    void open_drive(const DacInfo& dac);
    void open_accelerometer(const AccelerometerInfo& info);
    void open_camera(const View& view, std::int64_t order);
    void open_group(const GroupLayout& layout);
    void open_once(const std::string& path, const Place& place);
    Numbered& column(const std::string& path);
    /// Cuts the opened file to its verified part, see RecordingWriter::mend().
    void mend();
    void reopen_once(const std::string& path, std::optional<std::uint32_t> checksum);
    void write_once(const std::string& path, std::span<const std::byte> value);
};

}  // namespace shaker::recorded
