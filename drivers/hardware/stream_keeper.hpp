#pragma once
// The kernel stops a sound stream at once, in the middle of the drive, when its last descriptor is closed: a
// killed process would end its drive with a step. A small process that holds the descriptor lets it play out.
#include <sys/types.h>

#include "drivers/time.hpp"

namespace shaker {

class StreamKeeper {
public:
    /// From now on `descriptor` stays open for `lasts` after this process' end, however it comes. Not
    /// real-time. Throws DeviceError when no process can be started.
    StreamKeeper(int descriptor, Seconds lasts);
    StreamKeeper(const StreamKeeper&) = delete;
    StreamKeeper& operator=(const StreamKeeper&) = delete;
    /// The keeper lets go at once; the descriptor is then this process' alone.
    ~StreamKeeper();

private:
    pid_t keeper_ = -1;
    int release_ = -1;  // a byte written here lets go; its end of file is this process' death
};

}  // namespace shaker
