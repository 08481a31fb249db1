#pragma once
// The service manager's end of a daemon's messages: readiness, signs of life.
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

namespace shaker::test {

/// Receives the daemon's messages to the service manager.
class ServiceManager {
public:
    /// watchdog_us: watchdog time of the daemon, microseconds; it sends eight signs of life in that time.
    explicit ServiceManager(const char* watchdog_us = "1000000")
        : path_{(std::filesystem::temp_directory_path() / ("notify-" + std::to_string(getpid()))).string()} {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::strncpy(address.sun_path, path_.c_str(), sizeof address.sun_path - 1);
        if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) std::abort();
        setenv("NOTIFY_SOCKET", path_.c_str(), 1);
        setenv("WATCHDOG_USEC", watchdog_us, 1);
    }
    ~ServiceManager() {
        ear_.request_stop();
        ear_.join();
        close(socket_);
        unlink(path_.c_str());
        unsetenv("NOTIFY_SOCKET");
        unsetenv("WATCHDOG_USEC");
    }
    ServiceManager(const ServiceManager&) = delete;
    ServiceManager& operator=(const ServiceManager&) = delete;

    /// True if this message arrives within the time, s; forgotten messages do not count.
    bool hears(const std::string& words, double limit_s) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>{limit_s};
        while (std::chrono::steady_clock::now() < end) {
            {
                const std::scoped_lock lock{mutex_};
                if (heard_.find(words) != std::string::npos) return true;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds{10});
        }
        return false;
    }
    /// The longest time without a sign of life since forget(), s.
    double longest_silence_s() {
        const std::scoped_lock lock{mutex_};
        return std::chrono::duration<double>(std::max(longest_, std::chrono::steady_clock::now() - fed_))
            .count();
    }
    /// Forgets the messages received until now.
    void forget() {
        const std::scoped_lock lock{mutex_};
        heard_.clear();
        longest_ = {};
        fed_ = std::chrono::steady_clock::now();
    }

private:
    std::string path_;
    int socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    std::mutex mutex_;
    std::string heard_;
    std::chrono::steady_clock::time_point fed_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::duration longest_{};
    // Reads all the time, because the sender waits while too many messages are unread.
    std::jthread ear_{[this](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
            pollfd ready{socket_, POLLIN, 0};
            if (poll(&ready, 1, 50) != 1) continue;
            char bytes[4096];
            const ssize_t n = recv(socket_, bytes, sizeof bytes, 0);
            const std::scoped_lock lock{mutex_};
            if (n <= 0) continue;
            heard_.append(bytes, static_cast<std::size_t>(n)).push_back('\n');
            if (std::string_view{bytes, static_cast<std::size_t>(n)} != "WATCHDOG=1") continue;
            longest_ = std::max(longest_, std::chrono::steady_clock::now() -
                                              std::exchange(fed_, std::chrono::steady_clock::now()));
        }
    }};
};

}  // namespace shaker::test
