# What runs in the virtual machine of tests/vm/run, and the host's part of it.
add_library(vm_support STATIC tests/vm/drive_device.cpp tests/vm/pattern.cpp tests/vm/heard_drive.cpp)
target_link_libraries(vm_support PUBLIC calibration_harmonics calibration_clocks drivers)
add_executable(vm_probe tests/vm/probe.cpp tests/vm/death.cpp tests/vm/switched_drive.cpp tests/support/devices/hard_stops.cpp)
target_link_libraries(vm_probe PRIVATE vm_support daemon_acquisition drivers_recorded drivers_hardware PkgConfig::alsa spdlog::spdlog)
add_executable(uhid_accelerometer tests/vm/uhid_accelerometer.cpp)
add_executable(uhid_gpio tests/vm/uhid_gpio.cpp)

add_executable(vm_tests tests/vm/pattern_test.cpp)
target_link_libraries(vm_tests PRIVATE vm_support GTest::gtest_main)
gtest_discover_tests(vm_tests DISCOVERY_TIMEOUT 60 PROPERTIES LABELS unit)
