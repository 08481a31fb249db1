# libFuzzer's programs, one a file: only the sources they need, all of them with its instrumentation. Included instead of
# everything else by the preset "fuzz".
if(NOT CMAKE_CXX_COMPILER_ID MATCHES Clang)
  message(FATAL_ERROR "libFuzzer comes with clang: cmake --preset fuzz")
endif()

file(GLOB language CONFIGURE_DEPENDS daemon/remote/access/*.cpp daemon/remote/scpi/*.cpp daemon/remote/instrument/*.cpp)
file(GLOB drivers CONFIGURE_DEPENDS drivers/*.cpp)  # what all others stand on; the linker takes what is asked for
set(port daemon/service/bench_port.cpp daemon/service/event_log.cpp daemon/service/pending_orders.cpp
    daemon/safety/trip.cpp tests/support/remote/played_port.cpp)
add_library(fuzzed_drivers STATIC ${drivers})
add_library(fuzzed_port STATIC ${port})
add_library(fuzzed_language STATIC ${language})
add_library(fuzzed_web STATIC daemon/remote/web/actions.cpp daemon/remote/web/metrics.cpp
            daemon/remote/web/picture_figures.cpp daemon/remote/web/requests.cpp daemon/remote/web/state_json.cpp
            daemon/remote/web/subscription.cpp tracking/clipping.cpp
            daemon/report/results.cpp)
foreach(library fuzzed_drivers fuzzed_port fuzzed_language fuzzed_web)
  target_include_directories(${library} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(${library} PUBLIC shaker_hdf5 Boost::headers nlohmann_json::nlohmann_json spdlog::spdlog
                        tomlplusplus::tomlplusplus Eigen3::Eigen Threads::Threads)
endforeach()

foreach(name scpi http websocket)
  add_executable(fuzz_${name} tests/fuzz/${name}.cpp)
  target_link_libraries(fuzz_${name} PRIVATE fuzzed_web fuzzed_language fuzzed_port fuzzed_drivers -fsanitize=fuzzer)
endforeach()
