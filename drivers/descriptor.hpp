#pragma once
// Descriptor: owns a file descriptor of the system.
#include <unistd.h>

#include <utility>

namespace shaker {

/// Closes its descriptor when it ends. Used like the number that it owns; negative: none.
class Descriptor {
public:
    explicit Descriptor(int fd = -1) noexcept : fd_{fd} {}
    Descriptor(Descriptor&& other) noexcept : fd_{std::exchange(other.fd_, -1)} {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    operator int() const noexcept { return fd_; }

private:
    int fd_;
};

}  // namespace shaker
