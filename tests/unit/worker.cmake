vacuform_test(worker_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/child_test.cpp ${CMAKE_CURRENT_LIST_DIR}/http_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/progress_bar_test.cpp ${CMAKE_CURRENT_LIST_DIR}/sandbox_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/work_folder_test.cpp ${CMAKE_CURRENT_LIST_DIR}/kept_scans_test.cpp
          ${PROJECT_SOURCE_DIR}/worker/cli/progress_bar.cpp
  LINKS vacuform_lease)
add_executable(sandbox_probe ${CMAKE_CURRENT_LIST_DIR}/sandbox_probe.cpp)
vacuform_rules(sandbox_probe)
target_compile_definitions(worker_test PRIVATE VACUFORM_SANDBOX_PROBE="$<TARGET_FILE:sandbox_probe>")
add_dependencies(worker_test sandbox_probe)
