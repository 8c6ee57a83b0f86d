vacuform_test(power_loss_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/power_loss_test.cpp ${CMAKE_CURRENT_LIST_DIR}/flushed_disk.cpp
  LINKS vacuform_store)
