#pragma once
// What the program does, one function a command. Each prints its result on standard output and what it is
// doing on standard error, and throws InputError or DeviceError when it cannot.
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/drive.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

struct RunOptions {
    std::string rig = "sim:";
    std::filesystem::path scene;  // empty: the paper's bench
    Drive drive;
    int periods = 40;
    int settle = 0;             // periods of the settled drive before them; 0: until the walker is steady
    std::filesystem::path out;  // empty: nothing is recorded
    std::filesystem::path trips = ".";  // folder for the last seconds of a stopped run that is not recorded
    KeptPictures pictures = KeptPictures::region;
    bool identify = true;     // find out the response before; else the data sheet's is taken
    bool closed_loop = true;  // measured harmonics correct the drive
    double mains_hz = 0;      // fitted beside the harmonics; 0: not
    bool threads = false;     // one thread a loop instead of lockstep
    bool real_time = false;   // with threads, a simulated rig is no faster than a real one
    bool json = false;
};
/// Drives the rig, measures, tracks, reduces, records.
void run(const RunOptions& options);

struct ServeOptions {
    std::filesystem::path settings;  // empty: what is built in
    std::string rig;                 // empty: that of the settings
    std::filesystem::path scene, page, recordings;
    int http_port = -1, scpi_port = -1;  // below 0: those of the settings
};

struct CheckOptions {
    std::string rig = "sim:";
    std::filesystem::path scene;  // of the simulated rig
    double frequency_hz = 20;
    double level = 0.02;  // of the DAC's full scale, each of two harmonics
    bool json = false;
};
/// Opens every device of a rig, plays a low-level self-test and tells what is right and what to look at.
/// False when something is bad.
bool check(const CheckOptions& options);

struct DevicesOptions {
    std::vector<std::string> iio;       // further places to look for accelerometers: "ip:host:port"
    std::string pcm;                    // this PCM instead of the sound cards' own
    std::filesystem::path alsa_config;  // that defines it
    bool json = false;
};
/// Prints what is connected and what it can do, in the words of a rig file.
void list_devices(const DevicesOptions& options);

struct ReplayOptions {
    enum class From { best, raw, tracks };
    std::filesystem::path file;
    From from = From::best;          // pictures where all of them were kept; else the stored tracks
    bool real_time = false;          // as slowly as it was recorded, told second by second
    std::vector<std::string> set{};  // "key=value": reduced with these instead of what was recorded
    bool json = false;
};
/// Recomputes a recording's results from its raw streams. True when they are identical to the bit, or when
/// other settings were asked for and what changed was told.
bool replay(const ReplayOptions& options);

struct RecoverOptions {
    std::filesystem::path file;  // or its .part
    bool json = false;
};
/// Finishes what a crash left of a recording: a new file under its name with all that can be vouched for. One
/// that was finished is only held against its checksums; false when it is not what was written.
bool recover(const RecoverOptions& options);

struct ExportOptions {
    enum class Format { csv, mat };
    std::filesystem::path file;
    std::filesystem::path folder;  // empty: FILE's name with the ending .export, beside it
    Format format = Format::csv;
    std::vector<std::string> what{"all"};  // first parts of tables' names
    bool json = false;
};
/// Writes a recording's tables as files for other people's tools, never over one that exists.
void export_recording(const ExportOptions& options);

struct ReduceOptions {
    std::filesystem::path session;
    std::filesystem::path out;  // empty: nothing is recorded
    KeptPictures pictures = KeptPictures::region;
    bool json = false;
};
/// Reduces a session that shakerd did not record.
void reduce_session(const ReduceOptions& options);

struct TrackOptions {
    std::filesystem::path session;
    std::filesystem::path out;  // CSV; empty: a summary only
    bool json = false;
};
/// Tracks the targets of a session.
void track_session(const TrackOptions& options);

}  // namespace shaker
