vacuform_test(worker_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/child_test.cpp ${CMAKE_CURRENT_LIST_DIR}/http_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/work_folder_test.cpp
  LINKS vacuform_lease)
