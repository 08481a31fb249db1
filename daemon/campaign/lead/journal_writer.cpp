#include "daemon/campaign/lead/journal_writer.hpp"

#include <chrono>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::campaign {

namespace {
constexpr std::chrono::milliseconds again_after{500};
}

JournalWriter::JournalWriter(CampaignFolder& folder, bool beside) : folder_{folder}, beside_{beside} {
    if (beside) thread_ = std::jthread{[this](const std::stop_token& stop) { work(stop); }};
}

JournalWriter::~JournalWriter() = default;

void JournalWriter::add(decltype(JournalEntry::what) what) {
    std::unique_lock lock{mutex_};
    waiting_.push_back(std::move(what));
    if (!beside_) return write_all(lock);
    changed_.notify_all();
}

std::string JournalWriter::failure() {
    std::unique_lock lock{mutex_};
    if (!beside_) write_all(lock);
    return failure_;
}

void JournalWriter::finish() {
    std::unique_lock lock{mutex_};
    if (!beside_) write_all(lock);
    changed_.wait(lock, [&] { return waiting_.empty() || !failure_.empty(); });
    if (!failure_.empty()) throw DeviceError{failure_};
}

// The lock is not held while the disk works.
void JournalWriter::write_all(std::unique_lock<std::mutex>& lock) {
    while (!waiting_.empty()) {
        const auto next = waiting_.front();
        std::string failure;
        lock.unlock();
        try {
            folder_.add(next);
        } catch (const DeviceError& e) {
            failure = e.what();
        }
        lock.lock();
        failure_ = std::move(failure);
        changed_.notify_all();
        if (!failure_.empty()) return;
        waiting_.pop_front();
    }
    changed_.notify_all();
}

void JournalWriter::work(const std::stop_token& stop) {
    std::unique_lock lock{mutex_};
    while (!stop.stop_requested()) {
        if (failure_.empty())
            changed_.wait(lock, stop, [&] { return !waiting_.empty(); });
        else
            changed_.wait_for(lock, stop, again_after, [] { return false; });
        write_all(lock);
    }
}

}  // namespace shaker::campaign
