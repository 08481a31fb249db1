#include "tests/mock/sound/mixer.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"
#include "tests/mock/sound/mixer_memory.hpp"

namespace shaker::mock {

MockMixer::MockMixer(const std::filesystem::path& file) : file_{file} {
    const Descriptor fd{::open(file.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600)};
    void* at = fd >= 0 && ::ftruncate(fd, sizeof(MixerMemory)) == 0
                   ? ::mmap(nullptr, sizeof(MixerMemory), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0)
                   : MAP_FAILED;
    if (at == MAP_FAILED) throw DeviceError{"mock mixer: " + file.string() + ": " + std::strerror(errno)};
    memory_ = static_cast<MixerMemory*>(at);
    set_volume(200);
    memory_->values[1][0] = 1;
    memory_->ready.store(MixerMemory::version, std::memory_order_release);
}

MockMixer::~MockMixer() {
    ::munmap(memory_, sizeof(MixerMemory));
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
}

void MockMixer::set_volume(long value) noexcept {
    for (auto& channel : memory_->values[0]) channel = value;
}

long MockMixer::volume() const noexcept { return memory_->values[0][0]; }

}  // namespace shaker::mock
