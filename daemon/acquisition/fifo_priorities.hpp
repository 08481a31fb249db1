#pragma once
// SCHED_FIFO priorities of the threads on hardware, 1 to 99. systemd/shakerd.service allows them.

namespace shaker::acquisition::fifo_priority {

inline constexpr int output = 70;
inline constexpr int abort_input = 66;
inline constexpr int accelerometer = 65;
inline constexpr int doors =
    60;  // reads aborts: above pictures; one more for the thread that watches its share
inline constexpr int camera = 50;
inline constexpr int recorder = 20;

}  // namespace shaker::acquisition::fifo_priority
