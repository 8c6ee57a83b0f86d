vacuform_test(worker_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/child_test.cpp ${CMAKE_CURRENT_LIST_DIR}/http_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/progress_bar_test.cpp ${CMAKE_CURRENT_LIST_DIR}/work_folder_test.cpp
          ${PROJECT_SOURCE_DIR}/worker/cli/progress_bar.cpp
  LINKS vacuform_lease)
