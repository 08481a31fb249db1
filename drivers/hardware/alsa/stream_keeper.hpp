#pragma once
// StreamKeeper: plays out the queued samples when the process is killed. The kernel stops a sound stream at
// once when its last descriptor is closed, so the drive would end with a step. A small process holds the
// descriptor.
#include <sys/types.h>

#include "drivers/time.hpp"

namespace shaker::alsa {

class StreamKeeper {
public:
    /// Keeps `descriptor` open for `lasts` after the end of this process, however it ends. Not real-time.
    /// Throws DeviceError when no process can be started.
    StreamKeeper(int descriptor, Seconds lasts);
    StreamKeeper(const StreamKeeper&) = delete;
    StreamKeeper& operator=(const StreamKeeper&) = delete;
    /// Ends the keeper at once; only this process then holds the descriptor.
    ~StreamKeeper();

private:
    pid_t controller_ = -1;
    int release_ = -1;  // writing a byte here ends the keeper; end of file means that this process has died
};

}  // namespace shaker::alsa
