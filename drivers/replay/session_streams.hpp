#pragma once
// The inside of a SessionWriter, shared by its beginning and its mending.
#include <list>
#include <map>
#include <optional>

#include "drivers/replay/crc32c.hpp"
#include "drivers/replay/seals.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

// A number or a text that is told once.
struct Once {
    h5::Handle set, type;
    std::size_t column;  // number under the seals
    hsize_t written = 0;
    std::int64_t checksum = 0;

    void write(std::span<const std::byte> value, const std::string& path) {
        h5::check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, value.data()), path);
        checksum = crc32c(value);
        written = 1;
    }
};

// A column and its number under the seals.
struct Numbered {
    h5::Growing data;
    std::size_t column;
    bool provisional = false;
};

struct SessionWriter::Streams {
    struct CameraStream {
        Numbered *tick, *arrived, *stamp, *mid_exposure, *quality, *picture;
    };
    h5::Handle file, entry;
    std::string name;
    std::vector<std::string> columns;  // paths, by their number
    std::list<Numbered> growing;       // in the order they were made
    std::map<std::string, Numbered*> by_path;
    std::map<std::string, Once> once;
    std::vector<std::vector<Numbered*>> tables;
    std::map<std::string, std::size_t> table_of;
    Numbered *play_tick, *play_heard, *play_lost;
    Numbered *counts, *block_first, *block_arrived, *block_quality, *block_size;
    struct {
        Numbered *first, *ramp, *stop, *ramp_periods, *phase, *phase_low, *step, *step_low, *sequence,
            *frequency, *re, *im;
    } change;
    std::vector<CameraStream> cameras;
    std::optional<SealWriter> seals;

    Numbered* grow(const std::string& path, hid_t type, std::vector<hsize_t> row, double rows_per_s,
                   const std::string& units, bool provisional = false);
    void begin(const SessionHeader& header);
    void open_drive(const DacInfo& dac);
    void open_accelerometer(const AccelerometerInfo& info);
    void open_camera(const View& view, std::int64_t order);
    void open_group(const GroupLayout& layout);
    void open_once(const std::string& path, const Place& place);
    Numbered& column(const std::string& path);
    /// Cuts the opened file to what can be vouched for, see SessionWriter::mend().
    void mend();
    void reopen_once(const std::string& path, std::optional<std::uint32_t> checksum);
    void write_once(const std::string& path, std::span<const std::byte> value);
};

}  // namespace shaker
