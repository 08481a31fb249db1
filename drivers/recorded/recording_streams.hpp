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
        Numbered *tick, *arrived, *stamp, *mid_exposure, *quality, *picture;
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
    Numbered *play_tick, *play_heard, *play_lost;
    Numbered *counts, *block_first, *block_arrived, *block_quality, *block_size;
    struct {
        Numbered *first, *ramp, *stop, *taken_back, *ramp_periods, *phase, *phase_low, *step, *step_low,
            *sequence, *frequency, *re, *im;
    } change;
    std::vector<CameraStream> cameras;
    std::optional<h5::SealWriter> seals;

    Numbered* grow(const std::string& path, hid_t type, std::vector<hsize_t> row, double rows_per_s,
                   const std::string& units, bool provisional = false);
    /// path: where it is not the column's own.
    Numbered* grow(const RawColumn& column, double rows_per_s, const std::string& path = {});
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
