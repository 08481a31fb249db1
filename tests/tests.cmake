# Every tests/<folder>/*_test.cpp becomes part of one program a folder; tests/tiers gives each file its tier.
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)
include(GoogleTest)

set(sanitized 0)
if(SHAKER_SANITIZE)
  set(sanitized 1)
endif()
file(GLOB_RECURSE support CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/support/*.cpp)
add_library(test_support STATIC)
set(libraries PUBLIC daemon_commands tests_mock GTest::gtest shaker_opencv opencv_video shaker_hdf5 Eigen3::Eigen
  nlohmann_json::nlohmann_json spdlog::spdlog shaker_asio PRIVATE PkgConfig::seccomp)
target_link_libraries(test_support ${libraries})
set(level LEVEL 1)  # it draws pictures
if(SHAKER_SANITIZE)
  set(level "")  # g++ 12 warns of std::regex there
endif()
add_sources(test_support "${support}" "${libraries}" ${level})
target_compile_definitions(test_support PUBLIC SHAKER_SANITIZED=${sanitized})
set_source_files_properties(tests/support/paths.cpp PROPERTIES COMPILE_DEFINITIONS
  "SHAKER_SOURCE_DIR=\"${PROJECT_SOURCE_DIR}\";SHAKER_BINARY_DIR=\"${PROJECT_BINARY_DIR}\"")

add_library(test_main STATIC tests/main.cpp)
target_link_libraries(test_main PUBLIC GTest::gtest)

# The rows of tests/tiers: tier_FILE and options_FILE.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/tiers
  ${PROJECT_SOURCE_DIR}/tests/nightly ${PROJECT_SOURCE_DIR}/tests/guards)
file(STRINGS ${PROJECT_SOURCE_DIR}/tests/tiers rows REGEX "^[a-z]")
foreach(row ${rows})
  string(REGEX REPLACE " +" ";" words "${row}")
  list(POP_FRONT words file tier)
  if(NOT tier MATCHES "^(unit|virtual|realtime)$")
    message(FATAL_ERROR "tests/tiers: ${file}: the tier is unit, virtual or realtime, not '${tier}'")
  elseif(NOT EXISTS ${PROJECT_SOURCE_DIR}/tests/${file}.cpp)
    message(FATAL_ERROR "tests/tiers: tests/${file}.cpp does not exist; remove its row or correct the name")
  elseif(DEFINED tier_${file})
    message(FATAL_ERROR "tests/tiers: ${file} has two rows")
  endif()
  set(tier_${file} ${tier})
  set(options_${file} ${words})
endforeach()

# The rows of tests/nightly that hold for this preset: nightly_FILE is what gtest's filter leaves out. A test that guards a
# person stays in the gate of the presets without a sanitiser.
file(STRINGS ${PROJECT_SOURCE_DIR}/tests/guards guards REGEX "^[A-Z*]")
if(NOT SHAKER_NIGHTLY)
  file(STRINGS ${PROJECT_SOURCE_DIR}/tests/nightly rows REGEX "^[a-z]")
  foreach(row ${rows})
    string(REGEX REPLACE " +" ";" words "${row}")
    list(POP_FRONT words file presets test)
    if(NOT DEFINED tier_${file})
      message(FATAL_ERROR "tests/nightly: ${file} has no row in tests/tiers")
    elseif(NOT presets MATCHES "^(all|sanitised)$")
      message(FATAL_ERROR "tests/nightly: ${file}: the presets are all or sanitised, not '${presets}'")
    endif()
    foreach(guard ${guards})
      string(REPLACE "*" ".*" guard "${guard}")
      if(presets STREQUAL all AND test MATCHES "^${guard}$")
        message(FATAL_ERROR "tests/nightly: ${test} guards a person (tests/guards) and stays in the gate")
      endif()
    endforeach()
    if(presets STREQUAL all OR SHAKER_SANITIZE)
      list(APPEND nightly_${file} ${test})
    endif()
  endforeach()
endif()

# plays(FILE OUT): whether this preset has the tests of that file.
function(plays file out)
  set(${out} TRUE PARENT_SCOPE)
  if(SHAKER_SANITIZE MATCHES thread)
    set(wanted threads)
  elseif(SHAKER_SANITIZE AND NOT SHAKER_NIGHTLY)
    set(wanted bytes)
  else()
    return()
  endif()
  if(NOT wanted IN_LIST options_${file} AND NOT (SHAKER_NIGHTLY AND "threads=nightly" IN_LIST options_${file}))
    set(${out} FALSE PARENT_SCOPE)
  endif()
endfunction()

# Other tests give way to those against real time, where those may not take a higher priority (tests/support/judged).
execute_process(COMMAND nice -n -10 true RESULT_VARIABLE refused OUTPUT_QUIET ERROR_QUIET)
if(refused)
  set(behind nice -n 10)
endif()
set(judged ${PROJECT_SOURCE_DIR}/tests/support/judged)

# list_tests(PROGRAM FILE): ctest's entries for the tests of a file, labelled with its tier. One entry per file; one per
# test in tier realtime, so that it can be judged and repeated alone.
function(list_tests program file)
  set(filter file:${file})
  if(nightly_${file})
    list(JOIN nightly_${file} ":" left_out)
    string(APPEND filter "-${left_out}")
  endif()
  set(tsan "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/support/tsan.supp")
  set(lsan "LSAN_OPTIONS=set:suppressions=${PROJECT_SOURCE_DIR}/tests/support/lsan.supp:print_suppressions=0")
  if(tier_${file} STREQUAL realtime)
    set(lock realtime)
    if("bench" IN_LIST options_${file})
      set(lock bench)
    endif()
    set_target_properties(${program} PROPERTIES CROSSCOMPILING_EMULATOR ${judged})
    gtest_discover_tests(${program} TEST_FILTER ${filter} DISCOVERY_TIMEOUT 60 NO_PRETTY_VALUES
      PROPERTIES TIMEOUT 2400 COST 1000
      RESOURCE_LOCK ${lock} LABELS realtime ENVIRONMENT "${tsan}" ENVIRONMENT_MODIFICATION "${lsan}")
    return()
  endif()
  add_test(NAME ${file} COMMAND ${behind} $<TARGET_FILE:${program}> --gtest_filter=${filter}
    --gtest_output=xml:${PROJECT_BINARY_DIR}/results/${file}.xml)
  set_tests_properties(${file} PROPERTIES TIMEOUT 1200 LABELS ${tier_${file}} ENVIRONMENT "${tsan}"
    ENVIRONMENT_MODIFICATION "${lsan}")
endfunction()

# Only programs that link OpenCV's movies use this object of the library.
set_source_files_properties(tests/support/tracking/grey_movie.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)

if(SHAKER_SANITIZE)  # Eigen's intrinsics need it
  set_source_files_properties(tests/tracking/building_swing_test.cpp tests/calibration/harmonic_sums_test.cpp
    PROPERTIES COMPILE_OPTIONS -O1 SKIP_PRECOMPILE_HEADERS ON)
endif()

# compile_tests(TARGET [HEADER...]): with test_support, and these headers precompiled beside those that most tests include.
# Assertions cost the compiler most of the build's time: they are optimised less than what they look at.
function(compile_tests target)
  string(MAKE_C_IDENTIFIER "precompiled_tests${ARGN}" name)
  set(making ${target})
  if(NOT TARGET ${name})
    list(APPEND making ${name})
  endif()
  foreach(made ${making})
    if(NOT TARGET ${made})
      add_library(${made} OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/precompiled.cpp)
      target_precompile_headers(${made} PRIVATE <gtest/gtest.h> <algorithm> <array> <chrono> <cmath> <complex> <filesystem>
        <fstream> <functional> <map> <memory> <optional> <random> <span> <spdlog/fmt/fmt.h> <string> <thread> <vector>
        <boost/lockfree/spsc_queue.hpp> ${ARGN})
    endif()
    target_link_libraries(${made} PRIVATE test_support)
    target_compile_options(${made} PRIVATE -O$<NOT:${sanitized}> -g1)
    if(SHAKER_SANITIZE MATCHES undefined)
      target_compile_options(${made} PRIVATE -fno-sanitize=undefined)
    endif()
  endforeach()
  target_precompile_headers(${target} REUSE_FROM ${name})
endfunction()

# One program a folder that holds tests.
file(GLOB_RECURSE test_files CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/tests/*_test.cpp)
list(FILTER test_files EXCLUDE REGEX "^(long|vm)/")
foreach(file ${test_files})
  string(REGEX REPLACE "\\.cpp$" "" file ${file})
  if(NOT DEFINED tier_${file})
    message(FATAL_ERROR "tests/tiers has no row for tests/${file}.cpp; add one: ${file} unit (or virtual, realtime)")
  endif()
  plays(${file} played)
  if(NOT played)
    continue()
  endif()
  get_filename_component(folder ${file} DIRECTORY)
  string(REPLACE "/" "_" area ${folder})
  if(NOT TARGET ${area}_tests)
    add_executable(${area}_tests)
    target_link_libraries(${area}_tests PRIVATE test_main)
    compile_tests(${area}_tests)
  endif()
  file(STRINGS tests/${file}.cpp json REGEX "^#include <nlohmann/json.hpp>" LIMIT_COUNT 1)
  if(json)  # as in add_sources
    if(NOT TARGET ${area}_tests_json)
      add_library(${area}_tests_json OBJECT)
      compile_tests(${area}_tests_json <nlohmann/json.hpp>)
      target_sources(${area}_tests PRIVATE $<TARGET_OBJECTS:${area}_tests_json>)
    endif()
    target_sources(${area}_tests_json PRIVATE tests/${file}.cpp)
  else()
    target_sources(${area}_tests PRIVATE tests/${file}.cpp)
  endif()
  list_tests(${area}_tests ${file})
endforeach()
function(also_links program)
  if(TARGET ${program})
    target_link_libraries(${program} PRIVATE ${ARGN})
  endif()
endfunction()
also_links(drivers_hardware_tests PkgConfig::libiio)
also_links(mock_tests PkgConfig::libiio)
also_links(calibration_tests opencv_aruco opencv_calib3d)
also_links(drivers_optics_tests opencv_aruco opencv_calib3d)
foreach(program drivers_footage_tests drivers_hardware_tests tracking_tests)  # they write and read movies themselves
  also_links(${program} opencv_imgcodecs opencv_videoio)
endforeach()
plays(daemon/remote/ctl_commands_test played)
if(played)
  also_links(daemon_remote_tests daemon_remote_ctl)
  add_dependencies(daemon_remote_tests shakerctl pages)
endif()
plays(golden/help_test played)
if(played)
  also_links(golden_tests daemon_remote_ctl)
  add_dependencies(golden_tests shakerctl)
endif()
plays(daemon/commands/messages_test played)
if(played)
  add_dependencies(daemon_commands_tests shakerctl)
endif()
add_dependencies(test_support shakerd shaker-mock shaker_mock_pcm shaker_codecs)

# The simulator of orders and faults, for its tests and for tests/bench/orders.cpp. An object library: it replaces
# functions of the C library in its program.
file(GLOB orders_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/orders/*.cpp)
list(FILTER orders_sources EXCLUDE REGEX "_test\\.cpp$")
add_library(orders OBJECT EXCLUDE_FROM_ALL ${orders_sources})
target_link_libraries(orders PUBLIC test_support)
compile_fast(orders)
also_links(orders_tests orders)

# What is put between a program and its system by LD_PRELOAD: tests/preload/<name>.cpp.
file(GLOB preloads CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/preload/*.cpp)
foreach(source ${preloads})
  get_filename_component(name ${source} NAME_WE)
  add_library(preload_${name} MODULE ${source})
  target_include_directories(preload_${name} PRIVATE ${PROJECT_SOURCE_DIR})
  set_target_properties(preload_${name} PROPERTIES PREFIX "")
  add_dependencies(test_support preload_${name})
endforeach()

# Sessions whose files mean something else than they say.
if(NOT SHAKER_SANITIZE)
  add_test(NAME fuzz/meaning COMMAND ${PROJECT_SOURCE_DIR}/tests/fuzz/meaning $<TARGET_FILE:shakerd> --count 24)
  set_tests_properties(fuzz/meaning PROPERTIES TIMEOUT 300 SKIP_RETURN_CODE 77 LABELS virtual)
endif()

# What the fuzzers read (tests/fuzz) and mutations of it, without libFuzzer.
if(NOT SHAKER_SANITIZE MATCHES thread)
  foreach(name scpi http websocket)
    add_executable(fuzz_replay_${name} tests/fuzz/${name}.cpp tests/fuzz/replay.cpp)
    target_link_libraries(fuzz_replay_${name} PRIVATE test_support)
    compile_fast(fuzz_replay_${name})
    set_target_properties(fuzz_replay_${name} PROPERTIES UNITY_BUILD OFF)
    if(NOT SHAKER_SANITIZE)
      target_compile_options(fuzz_replay_${name} PRIVATE -O1)
    endif()
    add_test(NAME fuzz/${name} COMMAND fuzz_replay_${name} ${PROJECT_SOURCE_DIR}/tests/fuzz/corpus/${name})
    set_tests_properties(fuzz/${name} PROPERTIES TIMEOUT 300 LABELS unit)
  endforeach()
endif()

add_test(NAME tally COMMAND ${PROJECT_SOURCE_DIR}/tests/support/tally_test)
add_test(NAME judged COMMAND ${PROJECT_SOURCE_DIR}/tests/support/judged_test)
add_test(NAME include_order COMMAND ${PROJECT_SOURCE_DIR}/tests/include_order ${PROJECT_SOURCE_DIR})
add_test(NAME sizes COMMAND ${PROJECT_SOURCE_DIR}/tests/sizes ${PROJECT_SOURCE_DIR})
add_test(NAME requirements COMMAND ${PROJECT_SOURCE_DIR}/tests/requirements ${PROJECT_SOURCE_DIR})
add_test(NAME real_time COMMAND ${PROJECT_SOURCE_DIR}/tests/real_time ${PROJECT_SOURCE_DIR})
add_test(NAME tick_times COMMAND ${PROJECT_SOURCE_DIR}/tests/tick_times ${PROJECT_SOURCE_DIR})
add_test(NAME held_states COMMAND ${PROJECT_SOURCE_DIR}/tests/held_states ${PROJECT_SOURCE_DIR})
add_test(NAME plain_words COMMAND ${PROJECT_SOURCE_DIR}/tests/plain_words ${PROJECT_SOURCE_DIR})

if(SHAKER_SANITIZE)  # what follows is run from the other presets
  return()
endif()

# What has the label "starved" does not claim real time: tests/run --stalls stops and starves it.
foreach(name report recording_report plot)
  add_test(NAME ${name} COMMAND ${judged} --plain --once --name ${name}
    /usr/bin/python3 ${PROJECT_SOURCE_DIR}/tests/daemon/report/${name}_test.py)
  set_tests_properties(${name} PROPERTIES ENVIRONMENT SHAKER_BUILD=${PROJECT_BINARY_DIR} TIMEOUT 300 COST 20
                       LABELS "unit;starved")
endforeach()

include(tests/vm/vm.cmake)

# On demand only: tests/run --long.
file(GLOB long_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/long/*_test.cpp)
add_executable(long_tests EXCLUDE_FROM_ALL ${long_sources})
target_link_libraries(long_tests PRIVATE test_support GTest::gtest_main)
add_dependencies(long_tests shakerd)

# One program a bench: tests/bench/<name>.cpp; tests/bench/run builds and starts them, tests/run --nightly compiles all.
add_custom_target(on_demand DEPENDS long_tests)
file(GLOB benches CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/bench/*.cpp)
list(FILTER benches EXCLUDE REGEX "/table\\.cpp$")
add_library(bench_table OBJECT EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/tests/bench/table.cpp)
target_include_directories(bench_table PUBLIC ${PROJECT_SOURCE_DIR})
foreach(source ${benches})
  get_filename_component(name ${source} NAME_WE)
  add_executable(bench_${name} EXCLUDE_FROM_ALL ${source})
  add_dependencies(on_demand bench_${name})
  target_link_libraries(bench_${name} PRIVATE bench_table test_support benchmark::benchmark)
  if(name STREQUAL "tracking")
    target_link_libraries(bench_${name} PRIVATE opencv_videoio)
  endif()
  if(name MATCHES "intrusions|kills|power_cuts|disk_faults|remote|campaigns")  # of the whole program
    add_dependencies(bench_${name} shakerd)
  elseif(name STREQUAL "orders")
    target_link_libraries(bench_orders PRIVATE orders)
  elseif(name STREQUAL aborts)
    add_dependencies(bench_${name} shakerctl)
  endif()
endforeach()

# Runs in the machine of tests/systemd/run, which has a systemd.
add_executable(service_deaths tests/systemd/deaths.cpp)
target_link_libraries(service_deaths PRIVATE bench_table test_support)
foreach(job package deaths)
  add_test(NAME systemd_${job} COMMAND ${judged} --name systemd_${job} ${PROJECT_SOURCE_DIR}/tests/systemd/run ${job})
  set_tests_properties(systemd_${job} PROPERTIES ENVIRONMENT SHAKER_BUILD=${PROJECT_BINARY_DIR} SKIP_RETURN_CODE 77
                       TIMEOUT 7200 RESOURCE_LOCK bench COST 1000 LABELS realtime)
endforeach()

# Programs for the scripts in tests/peers, which try the mock devices against software of others.
file(GLOB peers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/peers/*.cpp)
foreach(source ${peers})
  get_filename_component(name ${source} NAME_WE)
  if(name STREQUAL live_recording)  # for peers/hdf5
    add_executable(peer_${name} ${source})
  else()
    add_executable(peer_${name} EXCLUDE_FROM_ALL ${source})
    add_dependencies(on_demand peer_${name})
  endif()
  target_link_libraries(peer_${name} PRIVATE test_support)
endforeach()

# These need no device; "package" installs where it has the rights.
foreach(peer hdf5 remote package)
  add_test(NAME peers_${peer} COMMAND ${judged} --plain --name peers_${peer} ${PROJECT_SOURCE_DIR}/tests/peers/${peer})
  set_tests_properties(peers_${peer} PROPERTIES ENVIRONMENT SHAKER_BUILD=${PROJECT_BINARY_DIR} SKIP_RETURN_CODE 77
                       TIMEOUT 2400 RESOURCE_LOCK realtime COST 1000 LABELS "realtime;starved")
endforeach()

# Python: files, and a bench that is served.
add_test(NAME python COMMAND ${judged} --plain --name python ${PROJECT_SOURCE_DIR}/tests/daemon/python/python_test.py)
set_tests_properties(python PROPERTIES ENVIRONMENT SHAKER_BUILD=${PROJECT_BINARY_DIR} TIMEOUT 600
                     RESOURCE_LOCK realtime COST 1000 LABELS "realtime;starved")

# README's commands, the lines that it shows of their output, and its picture.
add_test(NAME readme COMMAND ${behind} ${PROJECT_SOURCE_DIR}/tests/daemon/report/readme_test.py)
set_tests_properties(readme PROPERTIES ENVIRONMENT SHAKER_BUILD=${PROJECT_BINARY_DIR} TIMEOUT 600 COST 20 LABELS virtual)

# An archive's jobs and table, on local cores.
add_test(NAME archive COMMAND ${behind} ${judged} --plain --once --name archive
  ${PROJECT_SOURCE_DIR}/tests/daemon/archive/archive_test.py)
set_tests_properties(archive PROPERTIES ENVIRONMENT SHAKER_BUILD=${PROJECT_BINARY_DIR} TIMEOUT 600 COST 20
                     LABELS "virtual;starved")

# The operator's page in a real browser.
set(panel_parts bundle pure page looks results control abort targets memory daemon soak)
if(SHAKER_NIGHTLY)
  list(APPEND panel_parts newcomer)
endif()
set(claims_time abort memory daemon soak newcomer)
set(labels_soak realtime)  # it measures shares of a core
foreach(part ${panel_parts})
  if(NOT DEFINED labels_${part})
    set(labels_${part} realtime starved)
  endif()
  set(same --same)
  if(part IN_LIST claims_time)
    unset(same)
  endif()
  add_test(NAME panel_${part} COMMAND ${judged} --plain ${same} --name panel_${part} ${PROJECT_SOURCE_DIR}/tests/panel/run --only ${part})
  set_tests_properties(panel_${part} PROPERTIES ENVIRONMENT SHAKERD=$<TARGET_FILE:shakerd>
                       SKIP_RETURN_CODE 77 TIMEOUT 2400 RESOURCE_LOCK realtime COST 1000 LABELS "${labels_${part}}")
endforeach()
