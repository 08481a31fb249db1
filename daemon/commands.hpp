#pragma once
// What the program does, one function a command. Each prints its result on standard output and what it is
// doing on standard error, and throws InputError or DeviceError when it cannot.
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/drive.hpp"

namespace shaker {

struct RunOptions {
    std::string rig = "sim:";
    std::filesystem::path scene;  // empty: the paper's bench
    Drive drive;
    int periods = 40;
    std::filesystem::path out;          // empty: nothing is recorded
    std::filesystem::path trips = ".";  // folder for the last seconds of a stopped run that is not recorded
    bool keep_frames = true;
    bool identify = true;     // find out the response before; else the data sheet's is taken
    bool closed_loop = true;  // measured harmonics correct the drive
    double mains_hz = 0;      // fitted beside the harmonics; 0: not
    bool threads = false;     // one thread a loop instead of lockstep
    bool json = false;
};
/// Drives the rig, measures, tracks, reduces, records.
void run(const RunOptions& options);

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
    std::filesystem::path file;
    bool json = false;
};
/// Recomputes a recording's results from its raw streams. True when they are identical to the bit.
bool replay(const ReplayOptions& options);

struct ReduceOptions {
    std::filesystem::path session;
    std::filesystem::path out;  // empty: nothing is recorded
    bool keep_frames = true;
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
