vacuform_test(coils_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/placement_test.cpp LINKS vacuform_coils)
