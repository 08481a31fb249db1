#include "tests/mock/sound/line_input.hpp"

#include <fcntl.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"
#include "tests/mock/sound/line_memory.hpp"

namespace shaker::mock {

LineInput::LineInput(const std::filesystem::path& file, double nominal_hz, double rate_hz, HostTime epoch)
    : file_{file} {
    const auto fail = [&] {
        throw DeviceError{"mock line input: " + file.string() + ": " + std::strerror(errno)};
    };
    const Descriptor fd{::open(file.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600)};
    if (fd < 0 || ::ftruncate(fd, sizeof(LineMemory)) != 0) fail();
    void* at = ::mmap(nullptr, sizeof(LineMemory), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (at == MAP_FAILED) fail();
    memory_ = static_cast<LineMemory*>(at);
    memory_->nominal_hz = nominal_hz;
    memory_->rate_hz = rate_hz;
    memory_->epoch_ns = epoch.time_since_epoch().count();
    memory_->ready.store(LineMemory::version, std::memory_order_release);
}

LineInput::~LineInput() {
    ::munmap(memory_, sizeof(LineMemory));
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
}

void LineInput::put(std::span<const std::array<std::int32_t, 2>> samples) noexcept {
    std::int64_t next = memory_->recorded;
    for (const auto& sample : samples) {
        LineMemory::Frame& frame = memory_->frame(next++);
        for (std::size_t k = 0; k < sample.size(); ++k) frame.at(k) = sample.at(k);
    }
    memory_->recorded.store(next, std::memory_order_release);
}

void LineInput::cause_overrun() noexcept { memory_->overrun = true; }
void LineInput::unplug() noexcept { memory_->unplugged = true; }
void LineInput::plug() noexcept { memory_->unplugged = false; }

}  // namespace shaker::mock
