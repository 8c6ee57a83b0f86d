vacuform_test(full_disk_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/full_disk_test.cpp ${CMAKE_CURRENT_LIST_DIR}/full_disk.cpp
  LINKS vacuform_service)
