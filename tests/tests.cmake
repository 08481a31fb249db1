# Every tests/<folder>/*_test.cpp becomes part of one program per folder; ctest lists each test by its own name.
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)
include(GoogleTest)
include(tests/vm/vm.cmake)

set(sanitized 0)
if(SHAKER_SANITIZE)
  set(sanitized 1)
endif()
file(GLOB support CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/support/*.cpp)
add_library(test_support STATIC ${support})
target_link_libraries(test_support PUBLIC daemon_remote daemon daemon_remote_scpi drivers_mock GTest::gtest shaker_opencv
                      shaker_hdf5 Eigen3::Eigen nlohmann_json::nlohmann_json Boost::headers)
compile_fast(test_support)
target_compile_definitions(test_support PUBLIC
  SHAKER_SOURCE_DIR="${PROJECT_SOURCE_DIR}" SHAKER_BINARY_DIR="${PROJECT_BINARY_DIR}"
  SHAKER_SANITIZED=${sanitized})

set(areas drivers hardware mock simulated scpi remote replay calibration tracking control reduction daemon safety loop)
if(SHAKER_SANITIZE MATCHES thread)
  list(REMOVE_ITEM areas simulated scpi replay calibration tracking control reduction safety)  # of one thread each
endif()
# Minutes of computing that a sanitiser makes many more, on code that other tests take it through as well:
# tests/run --all leaves these to the preset without one.
set(slow "*FaultMatrixTest.*:EnduranceTest.*:*ClosedLoopTest.*:*CoverageTest.*:*FineTest.*:*LongRunTest.*:PlantTableTest.*")
string(APPEND slow ":RunTest.The*:RunTest.With*:RunTest.Harder*:RunTest.ADrive*:RunTest.AWalker*:RunTest.Symmetric*:TripTimeTest.*")
string(APPEND slow ":ExportedRun.*:LongRecordTest.*:BuildingSwingTest.*:OtherFilesTest.Addresses*:SessionTest.L*:SessionTest.E*")
string(APPEND slow ":RecoverTest.A*:RecoverTest.N*:StoppedRunTest.B*:StoppedRunTest.W*:RunTest.AC*:RunTest.B*:RunTest.Se*:MutantsTest.*")
string(APPEND slow ":*IdentityTest.*:*EveryKindTest.*:*HardCaseTest.*:*NormalDriving.*:PowerCutsTest.*")
string(APPEND slow ":RunTest.Threads*:OnCallTest.M*:OnCallTest.ARun*")
set(quick "-${slow}")
if(SHAKER_SANITIZE MATCHES thread)  # the others have one thread
  set(quick "Alsa*:Formats/*:GenicamCameraTest.*:IioAccelerometerTest.*:IioStreamTest.*:VideoCameraTest.*:ConverterTest.*")
  string(APPEND quick ":GigeCameraTest.*:Iiod*:ClosedRunTest.*:*FaultTest.*:ShakerMockTest.*:FramePoolTest.*:RingTest.*")
  string(APPEND quick ":MailboxTest.*:RealtimeTest.*:LoopsTest.*:ExecutorsTest.*:RecordingTest.*:*DiskFaultsTest.*")
  string(APPEND quick ":ScpiPortTest.*:WebTest.*:WebTokenTest.*:HostileTest.*")
  set(slow "-${quick}")
endif()
function(list_tests program filter alone label)
  gtest_discover_tests(${program} TEST_FILTER "${filter}" DISCOVERY_TIMEOUT 60
    PROPERTIES TIMEOUT 600 RUN_SERIAL ${alone} LABELS "${label}"
    ENVIRONMENT "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/support/tsan.supp"
    ENVIRONMENT_MODIFICATION "LSAN_OPTIONS=set:suppressions=${PROJECT_SOURCE_DIR}/tests/support/lsan.supp:print_suppressions=0")
endfunction()

if(SHAKER_SANITIZE)  # Eigen's intrinsics need it
  set_source_files_properties(tests/tracking/building_swing_test.cpp tests/calibration/harmonic_sums_test.cpp
    PROPERTIES COMPILE_OPTIONS -O1 SKIP_PRECOMPILE_HEADERS ON)
endif()
foreach(area ${areas})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/${area}/*_test.cpp)
  if(sources)
    add_executable(${area}_tests ${sources})
    target_link_libraries(${area}_tests PRIVATE test_support GTest::gtest_main)
    # Assertions cost the compiler most of the build's time: they are optimised less than what they look at.
    target_compile_options(${area}_tests PRIVATE -O$<NOT:${sanitized}> -g1)
    if(SHAKER_SANITIZE MATCHES undefined)
      target_compile_options(${area}_tests PRIVATE -fno-sanitize=undefined)
    endif()
    if(precompiled)
      target_precompile_headers(${area}_tests REUSE_FROM ${precompiled})
    else()
      set(precompiled ${area}_tests)
      target_precompile_headers(${area}_tests PRIVATE <gtest/gtest.h> <algorithm> <array> <chrono> <cmath> <complex>
        <filesystem> <fstream> <functional> <map> <memory> <nlohmann/json.hpp> <optional> <random> <span>
        <spdlog/fmt/fmt.h> <string> <thread> <vector>)
    endif()
    set(alone FALSE)
    set(label "virtual time")
    set(virtual ${area}_tests)
    if(area MATCHES "hardware|mock|loop|remote")  # another test beside it takes its processor
      set(alone TRUE)
      set(label "real time")
      set(virtual)
    endif()
    list(APPEND virtual_programs ${virtual})
    list_tests(${area}_tests "${quick}" ${alone} "${label}")
    list_tests(${area}_tests "${slow}" ${alone} "${label}, slow")
  endif()
endforeach()
add_custom_target(virtual_tests DEPENDS ${virtual_programs})
if(TARGET hardware_tests)
  target_link_libraries(hardware_tests PRIVATE PkgConfig::libiio)
endif()
if(TARGET mock_tests)
  target_link_libraries(mock_tests PRIVATE PkgConfig::libiio)
endif()
if(TARGET daemon_tests)
  add_dependencies(daemon_tests shakerd)
  add_dependencies(loop_tests shakerd shaker-mock)
endif()
if(TARGET remote_tests)
  target_link_libraries(remote_tests PRIVATE daemon_remote_ctl)
  add_dependencies(remote_tests shakerctl pages)
endif()
add_dependencies(test_support shaker_mock_pcm)

# What is put between a program and its disk by LD_PRELOAD: tests/preload/<name>.cpp.
file(GLOB preloads CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/preload/*.cpp)
foreach(source ${preloads})
  get_filename_component(name ${source} NAME_WE)
  add_library(preload_${name} MODULE ${source})
  target_include_directories(preload_${name} PRIVATE ${PROJECT_SOURCE_DIR})
  set_target_properties(preload_${name} PROPERTIES PREFIX "")
  add_dependencies(test_support preload_${name})
endforeach()

add_test(NAME include_order COMMAND ${PROJECT_SOURCE_DIR}/tests/include_order ${PROJECT_SOURCE_DIR})

if(SHAKER_SANITIZE)  # what follows is run from the other presets
  return()
endif()

# On demand only: tests/run --long.
file(GLOB long_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/long/*_test.cpp)
add_executable(long_tests ${long_sources})
target_link_libraries(long_tests PRIVATE test_support GTest::gtest_main)
add_dependencies(long_tests shakerd)

# One program a bench: tests/bench/<name>.cpp; tests/bench/run starts them.
file(GLOB benches CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/bench/*.cpp)
foreach(source ${benches})
  get_filename_component(name ${source} NAME_WE)
  add_executable(bench_${name} ${source})
  target_link_libraries(bench_${name} PRIVATE test_support benchmark::benchmark)
  if(name MATCHES "kills|power_cuts|disk_faults|remote")  # of the whole program
    add_dependencies(bench_${name} shakerd)
  endif()
endforeach()

# Programs for the scripts in tests/peers, which try the mock devices against software of others.
file(GLOB peers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/peers/*.cpp)
foreach(source ${peers})
  get_filename_component(name ${source} NAME_WE)
  add_executable(peer_${name} ${source})
  target_link_libraries(peer_${name} PRIVATE test_support)
endforeach()

# These need no device; "package" installs where it has the rights.
foreach(peer hdf5 remote package)
  add_test(NAME peers_${peer} COMMAND ${PROJECT_SOURCE_DIR}/tests/peers/${peer})
  set_tests_properties(peers_${peer} PROPERTIES ENVIRONMENT SHAKER_BUILD=${PROJECT_BINARY_DIR} SKIP_RETURN_CODE 77
                       TIMEOUT 300 RUN_SERIAL TRUE LABELS "real time")
endforeach()

# The operator's page in a real browser.
foreach(part pure page control memory daemon)
  add_test(NAME panel_${part} COMMAND ${PROJECT_SOURCE_DIR}/tests/panel/run --only ${part})
  set_tests_properties(panel_${part} PROPERTIES ENVIRONMENT SHAKERD=$<TARGET_FILE:shakerd>
                       TIMEOUT 400 RUN_SERIAL TRUE LABELS "real time")
endforeach()
